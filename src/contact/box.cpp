#include "udar/contact/box.hpp"

#include <algorithm>
#include <array>
#include <sstream>
#include <string>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr std::array kSides{SupportSide::below, SupportSide::above};
constexpr std::array kAlong{&Place::x, &Place::y, &Place::z};

/// What stands in front of a face, its edges included.
Region before_face(Region box, double Place::* along, SupportSide side) {
  if (side == SupportSide::below) {
    box.from.*along = box.to.*along;
    box.to.*along = Region::kEnd;
  } else {
    box.to.*along = box.from.*along;
    box.from.*along = -Region::kEnd;
  }
  return box;
}

std::string name_of(const Region& box) {
  std::ostringstream text;
  text << "support box: " << box.from.x << "," << box.to.x << "," << box.from.y << "," << box.to.y << "," << box.from.z
       << "," << box.to.z << " is not allowed, ";
  return text.str();
}

/// Refuses a node that is on the inner side of all faces.
void require_outside(const Region& box, std::span<const Place> nodes) {
  const auto inside = [&](const Place& node) {
    return std::ranges::none_of(kAlong, [&](double Place::* along) {
      return std::ranges::any_of(kSides, [&](SupportSide side) {
        Region half;
        const Region front = before_face(box, along, side);
        half.from.*along = front.from.*along;
        half.to.*along = front.to.*along;
        return half.holds(node);
      });
    });
  };
  if (const auto found = std::ranges::find_if(nodes, inside); found != nodes.end()) {
    std::ostringstream text;
    text << name_of(box) << "the node at (" << found->x << ", " << found->y << ", " << found->z
         << ") m is in it, expected one that is clear of the network where that stands (`network shift`) without its "
            "initial height [m]";
    throw InputError{text.str()};
  }
}

}  // namespace

std::vector<Support> box_faces(const Region& box, const Support& like, std::span<const Place> nodes) {
  if (!(box.from.x < box.to.x && box.from.y < box.to.y && box.from.z < box.to.z)) {
    throw InputError{name_of(box) + "expected from < to along x, y and z [m]"};
  }
  require_outside(box, nodes);
  std::vector<Support> faces;
  for (double Place::* const along : kAlong) {
    for (const SupportSide side : kSides) {
      const Region front = before_face(box, along, side);
      if (std::ranges::none_of(nodes, [&](const Place& node) { return front.holds(node); })) {
        continue;
      }
      Support& face = faces.emplace_back(like);
      face.width = Region::kEnd;
      face.normal = {};
      face.normal.*along = 1.0;
      face.side = side;
      face.height = (side == SupportSide::below ? box.to : box.from).*along;
      face.x = {.from = front.from.x, .to = front.to.x};
      face.y = {.from = front.from.y, .to = front.to.y};
      face.z = {.from = front.from.z, .to = front.to.z};
    }
  }
  if (faces.empty()) {
    throw InputError{name_of(box) + "expected one with nodes above, below or beside it [m]"};
  }
  return faces;
}

}  // namespace udar
