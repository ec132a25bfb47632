"""udar-report: a run as one HTML page.

streams   tables of any length, read a piece at a time and thinned
events    impacts, rests and touches; of many cells of a grid
fields    the motion of the structure, envelopes
spectra   spectra of the gauges
gather    all of one run as `Sheet`
verdict   what speaks for and against a run, and what it comes to
faces     supports in space
sketch    the case as a drawing
page      the HTML file, from `web`
cli       udar-report
"""
