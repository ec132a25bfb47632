#include <petscksp.h>
#include <petsctao.h>
#include <petscts.h>
#include <slepceps.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "petsc/option_keys.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/handle.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar::petsc {
namespace {

using Words = std::vector<std::string>;

/// PETSc's that are often asked for, by name: a slip in one of them would go unseen, too.
constexpr std::array kPetscKeys = {"-ts_type",       "-ts_monitor",   "-ts_max_steps", "-ts_rk_type",
                                   "-ts_adapt_type", "-options_file", "-log_view"};
/// What PETSc reads when everything else is done.
constexpr std::array kLateGroups = {"ts_view",  "options_", "log_",    "malloc",   "memory_",
                                    "objects_", "mat_view", "mpidump", "citations"};
/// A key nobody has read that is so many slips from a known one is taken for it.
constexpr std::size_t kSlips = 2;
/// A longer list of names is no help in a message of one line.
constexpr std::size_t kLongList = 260;

/// Fewest insertions, deletions, replacements and swaps of neighbours that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> cost(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        cost[i][j] = i + j;
        continue;
      }
      const std::size_t replaced = cost[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      cost[i][j] = std::min({replaced, cost[i - 1][j] + 1, cost[i][j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
      }
    }
  }
  return cost[a.size()][b.size()];
}

/// The one with the fewest slips; the rest of a word that was cut short counts as one.
template <class Candidates>
std::string nearest_to(const std::string& word, const Candidates& candidates) {
  const auto found = std::ranges::min_element(candidates, {}, [&word](const std::string& candidate) {
    return candidate != word && candidate.starts_with(word) ? 1 : edit_distance(word, candidate);
  });
  return found == candidates.end() ? "" : *found;
}

bool starts_with_any(std::string_view key, std::span<const char* const> prefixes) {
  return std::ranges::any_of(prefixes, [key](const char* prefix) { return key.starts_with(prefix); });
}

/// What is read of PETSc's solvers, and behind which prefix.
struct SolverGroup {
  std::string prefix;  ///< "filter_"
  std::string group;   ///< "ksp_"

  bool operator==(const SolverGroup&) const = default;
};

std::vector<SolverGroup>& solver_groups() {
  static std::vector<SolverGroup> groups;
  return groups;
}

/// The solver whose option a key, without its dash, is; null: none.
bool is_solver_key(std::string_view key) {
  return std::ranges::any_of(solver_groups(), [key](const SolverGroup& solver) {
    return key.starts_with(solver.prefix) && key.substr(solver.prefix.size()).starts_with(solver.group);
  });
}

std::string_view first_word(std::string_view key) { return key.substr(0, key.find('_')); }

/// Whether a key, without its dash, begins as one that we have read ourselves; those of the TS are PETSc's.
bool is_of_own_group(std::string_view key) {
  const std::string_view word = first_word(key);
  return word != "ts" && std::ranges::any_of(known_keys(), [word](const std::string& known) {
           return first_word(std::string_view{known}.substr(1)) == word &&
                  std::ranges::find(kPetscKeys, known) == kPetscKeys.end();
         });
}

/// Keys of the database that nobody has read, without their dash.
Words unread_keys() {
  PetscInt count = 0;
  char** names = nullptr;
  char** values = nullptr;
  UDAR_CALL(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  Words keys{names, names + count};
  UDAR_CALL(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  return keys;
}

bool is_key(const std::string& word) {
  PetscBool valid = PETSC_FALSE;
  UDAR_CALL(PetscOptionsValidKey(word.c_str(), &valid));
  return valid == PETSC_TRUE;
}

/// A key that PETSc would take for another, or for one that nobody knows.
void refuse_spelling(const std::string& key, const std::string& place) {
  const std::string bare = key.substr(key.find_first_not_of('-'));
  const std::size_t sign = bare.find('=');
  if (sign != std::string::npos) {
    throw InputError{"'" + key + "'" + place + ": options are written with a blank: -" + bare.substr(0, sign) + " " +
                     bare.substr(sign + 1)};
  }
  if (key.starts_with("--")) {
    throw InputError{"'" + key + "'" + place + ": options are written with one dash: -" + bare};
  }
}

/// Words from `first` on that are no keys.
Words values_from(std::span<const std::string> words, std::size_t first) {
  Words values;
  for (std::size_t i = first; i < words.size() && !is_key(words[i]); ++i) {
    values.push_back(words[i]);
  }
  return values;
}

/// As word processors write it: U+2010 to U+2015, or the minus sign U+2212.
bool starts_with_other_dash(const std::string& word) {
  return word.starts_with("\xe2\x80") || word.starts_with("\xe2\x88\x92");
}

/// @param key the last one before `word`, empty: none  @param before what it was given
[[noreturn]] void refuse_stray(const std::string& key, const std::string& before, const Words& rest,
                               const std::string& place) {
  const std::string& word = rest.front();
  std::string cause = "each option takes one word";
  if (starts_with_other_dash(word) || starts_with_other_dash(before)) {
    cause = "keys start with the dash '-' of the keyboard, not with a longer one";
  } else if (word.ends_with(".yaml") || word.ends_with(".yml")) {
    cause = "the case file comes first, further ones after -options_file each";
  } else if (word.find('=') != std::string::npos) {
    cause = "options are written -key value";
  } else if (!before.empty()) {
    std::string list = before;
    for (const std::string& part : rest) {
      list += (list.ends_with(',') || part.starts_with(',') ? "" : ",") + part;
    }
    cause = "a list is written without blanks: " + key + " " + list;
  }
  throw InputError{"'" + word + "'" +
                   (key.empty() ? "" : " after '" + key + (before.empty() ? "'" : " " + before + "'")) + place +
                   " belongs to no option; " + cause};
}

/// Types that PETSc keeps under names: the end of the keys that choose one, the names, and who judges a name where
/// these are not all.
struct NamedTypes {
  const char* key;
  Words names;
  bool (*accepts)(const char* name) = nullptr;
};

Words names_of(PetscFunctionList list) {
  const char** names = nullptr;
  int count = 0;
  UDAR_CALL(PetscFunctionListGet(list, &names, &count));
  Words words{names, std::find(names, names + count, nullptr)};  // the count may include the null pointer at the end
  UDAR_CALL(PetscFree(names));
  return words;
}

bool solver_package_exists(const char* name) {
  PetscBool found = PETSC_FALSE;
  UDAR_CALL(MatSolverTypeGet(name, MATSEQAIJ, MAT_FACTOR_LU, &found, nullptr, nullptr));
  return found == PETSC_TRUE;
}

bool accepted(PetscErrorCode code) {
  if (code != 0) {
    static_cast<void>(take_error_message());
  }
  return code == 0;
}

bool is_matrix(const char* name) {
  Matrix matrix;
  UDAR_CALL(MatCreate(PETSC_COMM_SELF, matrix.put()));
  UDAR_CALL(MatSetSizes(matrix, 1, 1, 1, 1));
  return accepted(MatSetType(matrix, name));
}

bool is_step_control(const char* name) {
  Handle<TSAdapt, TSAdaptDestroy> adapt;
  UDAR_CALL(TSAdaptCreate(PETSC_COMM_SELF, adapt.put()));
  return accepted(TSAdaptSetType(adapt, name));
}

bool is_tableau(const char* name) {
  TimeStepper stepper;
  UDAR_CALL(TSCreate(PETSC_COMM_SELF, stepper.put()));
  UDAR_CALL(TSSetType(stepper, TSRK));
  return accepted(TSRKSetType(stepper, name));
}

std::vector<NamedTypes> named_types() {
  UDAR_CALL(MatInitializePackage());
  UDAR_CALL(KSPInitializePackage());
  UDAR_CALL(PCInitializePackage());
  UDAR_CALL(TSInitializePackage());
  UDAR_CALL(TaoInitializePackage());
  UDAR_CALL(EPSInitializePackage());
  UDAR_CALL(STInitializePackage());
  // PETSc shows no list of these.
  Words packages{"petsc", "mumps",  "superlu",   "superlu_dist", "umfpack",     "cholmod",
                 "klu",   "pastix", "strumpack", "mkl_pardiso",  "mkl_cpardiso"};
  Words matrices = names_of(MatList);
  matrices.insert(matrices.end(), {"aij", "baij", "sbaij"});  // one name for one rank and several
  std::erase_if(packages, [](const std::string& name) { return !solver_package_exists(name.c_str()); });
  return {
      {.key = "ts_type", .names = names_of(TSList)},
      {.key = "ts_adapt_type", .names = {"none", "basic", "dsp", "cfl", "glee", "history"}, .accepts = is_step_control},
      {.key = "ts_rk_type",
       .names = {"1fe", "2a", "2b", "3", "3bs", "4", "5f", "5dp", "5bs", "6vr", "7vr", "8vr"},
       .accepts = is_tableau},
      {.key = "ksp_type", .names = names_of(KSPList)},
      {.key = "pc_type", .names = names_of(PCList)},
      {.key = "mat_type", .names = matrices, .accepts = is_matrix},
      {.key = "mat_ordering_type", .names = names_of(MatOrderingList)},
      {.key = "mat_solver_type", .names = packages, .accepts = solver_package_exists},
      {.key = "eps_type", .names = names_of(EPSList)},
      {.key = "st_type", .names = names_of(STList)},
      {.key = "tao_type", .names = names_of(TaoList)}};
}

void check_type_name(const std::string& key, const std::vector<NamedTypes>& types) {
  const auto kind = std::ranges::find_if(
      types, [&key](const NamedTypes& each) { return key == each.key || key.ends_with(std::string{"_"} + each.key); });
  if (kind == types.end()) {
    return;
  }
  const std::string option = "-" + key;
  const char* value = nullptr;
  PetscBool given = PETSC_FALSE;
  UDAR_CALL(PetscOptionsFindPair(nullptr, nullptr, option.c_str(), &value, &given));
  const std::string name{value != nullptr ? value : ""};
  if (std::ranges::find(kind->names, name) != kind->names.end() ||
      (kind->accepts != nullptr && kind->accepts(name.c_str()))) {
    return;
  }
  if (kind->names.empty()) {
    return;  // whoever uses it will say so
  }
  std::string list;
  for (const std::string& known : kind->names) {
    list += " " + known;
  }
  throw InputError{
      "option " + option + ": '" + name + "' is not allowed, the nearest is " + nearest_to(name, kind->names) + ", " +
      (list.size() < kLongList ? "expected one of" + list : "all are listed by -help " + std::string{kind->key}) +
      place_of(option)};
}

void refuse_forgotten_prefix(const std::string& key) {
  if (starts_with_any(key, kLateGroups)) {
    return;
  }
  if (key.starts_with("snes_")) {
    std::string starts;
    for (const auto& [prefix, group] : solver_groups()) {
      starts += " -" + prefix + group;
    }
    throw InputError{"option -" + key + place_of("-" + key) +
                     ": nothing here is solved by SNES; options of solvers start with one of" + starts};
  }
  const auto found = std::ranges::find_if(solver_groups(),
                                          [&key](const SolverGroup& solver) { return key.starts_with(solver.group); });
  if (found != solver_groups().end()) {
    throw InputError{"option -" + key + place_of("-" + key) + " belongs to no solver of udar; did you mean -" +
                     found->prefix + key + "?"};
  }
}

/// The key of a quantity, "-support_damping" of "support damping"; empty if there is none.
std::string key_of(const std::string& quantity) {
  std::string key = "-" + quantity;
  std::ranges::replace(key, ' ', '_');
  const bool petsc = key.starts_with("-ts_") || is_solver_key(std::string_view{key}.substr(1));
  const bool word = key.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789", 1) == std::string::npos;
  return word && (petsc || known_keys().contains(key)) ? key : "";
}

/// "option -a" of "a", "options -a, -b" of "a, b"; empty if one of them has no key.
std::string keys_of(const std::string& quantities) {
  std::string keys;
  std::size_t count = 0;
  for (std::size_t begin = 0; begin <= quantities.size(); ++count) {
    const std::size_t end = std::min(quantities.find(", ", begin), quantities.size());
    const std::string key = key_of(quantities.substr(begin, end - begin));
    if (key.empty()) {
      return {};
    }
    keys += (count > 0 ? ", " : "") + key;
    begin = end + 2;
  }
  return (count > 1 ? "options " : "option ") + keys;
}

}  // namespace

std::string with_option_keys(const std::string& message) {
  const std::size_t colon = message.find(':');
  const std::string head = colon != std::string::npos ? keys_of(message.substr(0, colon)) : "";
  std::string text = head.empty() ? message : head + message.substr(colon);
  for (std::size_t begin = text.find('`'); begin != std::string::npos;) {
    const std::size_t end = text.find('`', begin + 1);
    if (end == std::string::npos) {
      break;
    }
    const std::string key = key_of(text.substr(begin + 1, end - begin - 1));
    if (key.empty()) {
      begin = end;
      continue;
    }
    text.replace(begin, end - begin + 1, key);
    begin = text.find('`', begin + key.size());
  }
  return text;
}

std::set<std::string>& known_keys() {
  static std::set<std::string> keys{kPetscKeys.begin(), kPetscKeys.end()};
  return keys;
}

void add_solver_prefix(const std::string& prefix, std::span<const char* const> groups) {
  for (const char* group : groups) {
    const SolverGroup solver{.prefix = prefix, .group = group};
    if (std::ranges::find(solver_groups(), solver) == solver_groups().end()) {
      solver_groups().push_back(solver);
    }
  }
}

void add_known_key(const std::string& key) { known_keys().insert(key); }

Words option_words(const std::string& text) {
  Words words;
  const std::string blanks{" \t\n\r"};
  for (std::size_t begin = text.find_first_not_of(blanks); begin != std::string::npos;) {
    const bool quoted = text[begin] == '"' || text[begin] == '\'';
    const std::size_t first = begin + (quoted ? 1 : 0);
    const std::size_t end =
        std::min(quoted ? text.find(text[begin], first) : text.find_first_of(blanks, first), text.size());
    words.push_back(text.substr(first, end - first));
    begin = text.find_first_not_of(blanks, end + (quoted && end < text.size() ? 1 : 0));
  }
  return words;
}

void check_option_words(std::span<const std::string> words, const std::string& place) {
  std::string key;
  std::string value;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!is_key(words[i])) {
      refuse_stray(key, value, values_from(words, i), place);
    }
    key = words[i];
    refuse_spelling(key, place);
    const bool has_value = i + 1 < words.size() && !is_key(words[i + 1]) && key != "-prefix_pop";
    value = has_value ? words[++i] : "";
  }
}

void check_petsc_options() {
  const std::vector<NamedTypes> types = named_types();
  for (const std::string& key : unread_keys()) {
    refuse_forgotten_prefix(key);
    check_type_name(key, types);
  }
}

std::string unread_option(std::string_view group) {
  const Words keys = unread_keys();
  const auto found = std::ranges::find_if(keys, [&](const std::string& key) { return key.starts_with(group); });
  return found != keys.end() ? "-" + *found : std::string{};
}

void check_unknown_options(MPI_Comm comm, std::string_view group) {
  std::string unused;
  std::string unread;
  const auto add = [](std::string& list, const std::string& option) { list += (list.empty() ? "" : ", ") + option; };
  for (const std::string& key : unread_keys()) {
    if (!key.starts_with(group) || starts_with_any(key, kLateGroups)) {
      continue;
    }
    const std::string option = "-" + key;
    const std::string nearest = nearest_to(option, known_keys());
    const std::size_t slips = edit_distance(option, nearest);
    if (slips == 0 || is_solver_key(key)) {
      add(unused, option);
    } else if (slips <= kSlips || is_of_own_group(key)) {
      throw InputError{"unknown option " + option + place_of(option) + "; the nearest known option is " + nearest +
                       " (see -help)"};
    } else {
      add(unread, option);
    }
  }
  if (!unused.empty()) {
    warn(comm, "not used by the chosen solver: %s", unused.c_str());
  }
  if (!unread.empty()) {
    warn(comm, "read by nobody: %s", unread.c_str());
  }
}

}  // namespace udar::petsc
