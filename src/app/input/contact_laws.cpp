#include "app/input/contact_laws.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include "udar/contact/loading_curve.hpp"
#include "udar/contact/power_law.hpp"
#include "udar/io/table_file.hpp"
#include "udar/petsc/error.hpp"

namespace udar::app {
namespace {

constexpr std::array kKinds{
    Names<LawKind>{"none", LawKind::none},         Names<LawKind>{"hertz", LawKind::hertz},
    Names<LawKind>{"bilinear", LawKind::bilinear}, Names<LawKind>{"hunt_crossley", LawKind::hunt_crossley},
    Names<LawKind>{"crush", LawKind::crush},       Names<LawKind>{"table", LawKind::table}};

}  // namespace

void LawLists::read(petsc::OptionGroup& group) {
  given_ = group.choices<LawKind>(
      keys_->law, kind_, kKinds,
      "law of contact, in place of an impact law and of a spring; its force is shared by the masses that are touched: "
      "none; hertz, k d^1.5 over the compression d; hunt_crossley, k d^n (1 + c d'); bilinear, loading and unloading "
      "slope; crush, elastic, then a plateau, then bottoming out; table, a loading curve and an unloading slope. By "
      "-ts_type impact");
  stiffness_.read(group, "N/m^n", petsc::positive(),
                  "of hertz [N/m^1.5] and hunt_crossley [N/m^n]: k; of bilinear [N/m]: loading slope; of crush [N/m]: "
                  "elastic slope, of unloading, too");
  exponent_.read(group, "-", petsc::between(1.0, 3.0), "of hunt_crossley: n");
  damping_.read(group, "s/m", petsc::non_negative(), "of hunt_crossley: c");
  unloading_.read(
      group, "N/m", petsc::positive(),
      "of bilinear and table: slope along which the force falls and comes back, no less than any of loading");
  plateau_.read(group, "N", petsc::positive(), "of crush: force that crushes it");
  bottoming_.values = {std::numeric_limits<double>::infinity()};
  bottoming_.read(group, "m", petsc::positive_or_infinite(), "of crush: compression at which it bottoms out");
  bottoming_stiffness_.read(group, "N/m", petsc::non_negative(), "of crush: residual slope from there on");
  table_given_ = group.strings(keys_->table, table_,
                               "CSV files compression [m], force [N], of table: the loading curve from 0, 0 on; linear "
                               "between rows, with the last slope beyond; one each, or one for all; none");
  if (keys_->preload != nullptr) {
    preload_.read(group, "N", petsc::non_negative(),
                  "of any law: the face begins so far beyond -support_height that it presses with this force on masses "
                  "that are at -support_height");
  }
}

void LawLists::settle(std::size_t supports) {
  if (supports > 0 || given_) {
    kind_ = petsc::one_per(keys_->law, kind_, supports, keys_->per_thing);
  }
  for (NumberList* list :
       {&stiffness_, &exponent_, &damping_, &unloading_, &plateau_, &bottoming_, &bottoming_stiffness_, &preload_}) {
    if (supports > 0 || list->given) {
      list->spread(supports, keys_->per_thing);
    }
  }
  if (supports > 0 || table_given_) {
    table_ = petsc::one_per(keys_->table, table_, supports, keys_->per_thing);
  }
  refuse_idle();
}

/// Nothing that is given is to be ignored.
void LawLists::refuse_idle() const {
  struct Use {
    const char* key;
    bool given;
    std::vector<LawKind> by;
    const char* words;
  };
  using enum LawKind;
  const std::array<Use, 9> uses{{
      {stiffness_.key,
       stiffness_.given,
       {hertz, hunt_crossley, bilinear, crush},
       "hertz, hunt_crossley, bilinear or crush"},
      {exponent_.key, exponent_.given, {hunt_crossley}, "hunt_crossley"},
      {damping_.key, damping_.given, {hunt_crossley}, "hunt_crossley"},
      {unloading_.key, unloading_.given, {bilinear, table}, "bilinear or table"},
      {plateau_.key, plateau_.given, {crush}, "crush"},
      {bottoming_.key, bottoming_.given, {crush}, "crush"},
      {bottoming_stiffness_.key, bottoming_stiffness_.given, {crush}, "crush"},
      {keys_->table, table_given_, {table}, "table"},
      {preload_.key, preload_.given, {hertz, hunt_crossley, bilinear, crush, table}, "any but none"},
  }};
  for (const Use& use : uses) {
    const bool used =
        std::ranges::any_of(kind_, [&](LawKind kind) { return std::ranges::find(use.by, kind) != use.by.end(); });
    if (use.given && !used) {
      throw InputError{std::string{"option "} + use.key + " is not allowed without " + keys_->law + " " + use.words +
                       " of some " + keys_->thing};
    }
  }
}

const char* LawLists::name(std::size_t support) const {
  return std::ranges::find(kKinds, kind_[support], [](const auto& entry) { return entry.second; })->first;
}

std::shared_ptr<const ContactLaw> LawLists::law(MPI_Comm comm, std::size_t support) const {
  try {
    return made(comm, support);
  } catch (const InputError& error) {  // of a quantity of laws of supports
    const std::string text = error.what();
    const std::string quantity = "contact ";
    throw InputError{text.starts_with(quantity) ? keys_->quantity + text.substr(quantity.size() - 1) : text};
  }
}

std::shared_ptr<const ContactLaw> LawLists::made(MPI_Comm comm, std::size_t support) const {
  switch (kind_[support]) {
    case LawKind::none:
      return nullptr;
    case LawKind::hertz:
      return std::make_shared<PowerLaw>(PowerLaw::Parameters{.stiffness = stiffness_[support], .exponent = 1.5});
    case LawKind::hunt_crossley:
      return std::make_shared<PowerLaw>(PowerLaw::Parameters{
          .stiffness = stiffness_[support], .exponent = exponent_[support], .damping = damping_[support]});
    case LawKind::bilinear:
      return std::make_shared<LoadingCurve>(LoadingCurve::bilinear(stiffness_[support], unloading_[support]));
    case LawKind::crush:
      return std::make_shared<LoadingCurve>(
          LoadingCurve::crush({.stiffness = stiffness_[support],
                               .plateau = plateau_[support],
                               .bottoming = bottoming_[support],
                               .bottoming_stiffness = bottoming_stiffness_[support]}));
    case LawKind::table:
      break;
  }
  if (table_[support] == "none") {
    throw InputError{std::string{"option "} + keys_->table + " is needed with " + keys_->law +
                     " table: a file compression [m], force [N]"};
  }
  const io::Table table = io::read_table(comm, keys_->quantity + std::string{" table"}, table_[support],
                                         {.names = {"compression [m]", "force [N]"}});
  require_ascending(keys_->table, table_[support], column(table, 0), "compressions [m]");
  return std::make_shared<LoadingCurve>(LoadingCurve::table(column(table, 0), column(table, 1), unloading_[support]));
}

double LawLists::interference(const ContactLaw& law, std::size_t support) const {
  const double way = law.compression_for(preload_[support]);
  if (!std::isfinite(way)) {
    std::ostringstream message;
    message << "option " << keys_->preload << ": " << preload_[support]
            << " is not allowed, expected a force that the law of " << keys_->thing << ' ' << support
            << " (counted from 0) reaches on its loading curve [N]";
    throw InputError{message.str()};
  }
  return way;
}

void refuse_impact_law(const char* key, const char* decides, const NumberList& restitution, const char* yield_speed,
                       const Support& support) {
  const bool yields = std::isfinite(support.yield_speed);
  if (yields || (restitution.given && support.restitution != 1.0)) {
    std::ostringstream message;
    message << "option " << (yields ? yield_speed : restitution.key) << ": "
            << (yields ? support.yield_speed : support.restitution) << " is not allowed with " << key << ", expected "
            << (yields ? "inf" : "1") << ": " << decides << " how a mass leaves [-]";
    throw InputError{message.str()};
  }
}

}  // namespace udar::app
