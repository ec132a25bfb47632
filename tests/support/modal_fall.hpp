#pragma once
/// @file
/// The steel beam on two supports as a reduced model, without the program around it, and when it lands.

#include <cstddef>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "support/steel_beam.hpp"
#include "udar/modal/modal_model.hpp"
#include "udar/modal/modal_motion.hpp"

namespace udar::test {

/// Speed of a fall of 1 m [m/s].
inline const double kFallSpeed = std::sqrt(2.0 * kGravity);

/// At 2 and 8 m.
inline std::vector<LinePoint> two_points(PetscInt elements, double stiffness) {
  std::vector<LinePoint> points(2);
  points[0].node = elements / 5;
  points[1].node = 4 * elements / 5;
  points[0].compliance = points[1].compliance = 1.0 / stiffness;
  return points;
}

/// It touches its supports at t = 0, flat, after a fall of 1 m.
struct ModalFall {
  BeamChain beam;
  Loads weight;
  ModalModel model;

  ModalFall(PetscInt elements, const std::vector<LinePoint>& points, const ModalChoice& choice)
      : beam{PETSC_COMM_WORLD, steel_beam(elements)},
        weight{beam.points(), kGravity, {}},
        model{beam, {}, weight, std::vector<double>(beam.points().points(), 0.0), points, choice} {}

  void start(ModalMotion& motion) const {
    const std::size_t count = beam.points().points();
    motion.start(model.project(0.0, std::vector<double>(count, 0.0), std::vector<double>(count, -kFallSpeed)),
                 model.drive());
  }
  [[nodiscard]] double energy(const ModalState& state) const {
    return modal_energy(model.reduced(), model.drive(), state).total();
  }
  /// Of the centre of mass, of values by mode: weight acts on the modes as masses weigh in it.
  [[nodiscard]] double centre(std::span<const double> values) const {
    return std::inner_product(values.begin(), values.end(), model.drive().load.begin(), 0.0) /
           (-kGravity * beam.total_mass());
  }
  /// Speed with which the centre of mass passes the height of the first touch, over that of the fall.
  [[nodiscard]] double rebound(const ModalState& in_flight) const {
    const double speed = centre(in_flight.velocity);
    return std::sqrt(speed * speed + 2.0 * kGravity * centre(in_flight.amplitude)) / kFallSpeed;
  }
};

/// What a motion does up to a time.
struct Landings {
  std::vector<double> times;  // of touches after a flight of 0.1 s [s]
  double rebound = 0.0;       // after the first contact
  double lost = 0.0;          // radiated [J]
};

inline Landings land(const ModalFall& fall, ModalMotion& motion, double until) {
  constexpr double kFlight = 0.1;
  Landings landings;
  double left = 0.0;
  while (motion.now().time < until) {
    const double end = motion.advance(until);
    landings.lost += motion.flow(end).radiated;
    std::vector<ModalContact> contacts = motion.contacts();
    std::ranges::sort(contacts, {}, &ModalContact::from);
    for (const ModalContact& contact : contacts) {
      if (contact.from > left + kFlight) {
        landings.times.push_back(contact.from);
        if (landings.times.size() == 1) {
          landings.rebound = fall.rebound(motion.at(contact.from));
        }
      }
      left = std::max(left, contact.until);
    }
  }
  return landings;
}

}  // namespace udar::test
