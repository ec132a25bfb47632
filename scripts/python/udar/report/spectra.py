"""Spectra of the gauges' velocities: at which frequencies the structure moves."""
import numpy as np

SEGMENT = 1 << 16   # rows; longer runs are cut into pieces whose powers are averaged
LEAST_ROWS = 32
MOST_POINTS = 2000


def gather_spectra(table, names):
    """(frequencies [rad/s], amplitudes [m/s] with a row for each name, pieces); None of too few or uneven rows."""
    size = min(len(table) - 1, SEGMENT)  # the last row need not be an interval after the one before
    if size < LEAST_ROWS:
        return None
    window = np.hanning(size + 1)[:-1]
    trend = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, size), 1)
    power, pieces, step = 0.0, 0, None
    for rows in table.blocks(["time", *names], size):
        if len(rows) < size or not np.isfinite(rows).all():
            continue
        steps = np.diff(rows[:, 0])
        step = steps.mean() if step is None else step
        if np.abs(steps - step).max() > 1e-3 * step:
            continue
        values = rows[:, 1:] - trend @ np.linalg.lstsq(trend, rows[:, 1:], rcond=None)[0]
        power = power + np.abs(np.fft.rfft(values * window[:, None], axis=0))**2
        pieces += 1
    if not pieces:
        return None
    amplitude = 2.0 / window.sum() * np.sqrt(power / pieces)[1:]
    frequency = 2.0 * np.pi * np.arange(1, len(amplitude) + 1) / (size * step)
    return (*thin_spectrum(frequency, amplitude), pieces)


def thin_spectrum(frequency, amplitude):
    """The largest of each of so many parts of equal width on a logarithmic axis."""
    if len(frequency) <= MOST_POINTS:
        return frequency, amplitude.T
    part = np.floor(MOST_POINTS * np.log(frequency / frequency[0]) / np.log(frequency[-1] / frequency[0])).astype(int)
    first = np.flatnonzero(np.append(True, np.diff(part) != 0))
    return frequency[first], np.maximum.reduceat(amplitude, first, axis=0).T
