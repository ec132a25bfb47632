// ranks: 1; size: short
#include "udar/petsc/options.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "support/steel_beam.hpp"

namespace udar::petsc {
namespace {

using test::Option;

/// The message of the InputError that `action` throws.
template <class Action>
std::string refusal(const Action& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was refused";
}

void expect_parts(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) {
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is missing in: " << message;
  }
}

TEST(Options, KeepTheDefaultWhenNotGiven) {
  OptionGroup group{PETSC_COMM_WORLD, "test"};
  double value = 2.5;
  EXPECT_FALSE(group.real("-beam_test_real", value, "m", positive(), "text"));
  EXPECT_EQ(value, 2.5);
}

TEST(Options, NameOptionValueRangeAndUnit) {
  OptionGroup group{PETSC_COMM_WORLD, "test"};
  for (const char* bad : {"-1", "0", "nan", "inf", "1e", "abc", "1.5x"}) {
    const Option option{"-beam_test_real", bad};
    double value = 1.0;
    expect_parts(refusal([&] { group.real("-beam_test_real", value, "m", positive(), "text"); }),
                 {"-beam_test_real", bad, "> 0", "[m]"});
  }
  const Option option{"-beam_test_count", "2.5"};
  PetscInt count = 1;
  expect_parts(refusal([&] { group.integer("-beam_test_count", count, at_least(1), "text"); }),
               {"-beam_test_count", "2.5", "whole number", ">= 1"});
}

TEST(Options, ReadListsAndSpreadSingleValues) {
  OptionGroup group{PETSC_COMM_WORLD, "test"};
  const Option option{"-beam_test_list", "1, 2.5,+3e2"};
  std::vector<double> values;
  EXPECT_TRUE(group.reals("-beam_test_list", values, "m", positive(), "text"));
  EXPECT_EQ(values, (std::vector<double>{1.0, 2.5, 300.0}));
  EXPECT_EQ(one_per("-k", std::vector<double>{4.0}, 3, "things"), (std::vector<double>{4.0, 4.0, 4.0}));
  expect_parts(refusal([&] { (void)one_per("-k", values, 2, "things"); }), {"-k", "3 values", "1 or 2", "things"});
}

TEST(Options, NameTheAllowedWords) {
  OptionGroup group{PETSC_COMM_WORLD, "test"};
  const Option option{"-beam_test_word", "sqare"};
  constexpr std::array kNames{std::pair<const char*, int>{"round", 1}, std::pair<const char*, int>{"square", 2}};
  int value = 1;
  expect_parts(refusal([&] { group.choice<int>("-beam_test_word", value, kNames, "text"); }),
               {"-beam_test_word", "sqare", "round", "square"});
}

TEST(Options, RefuseAnUnknownKeyOfOursAndNameTheNearest) {
  OptionGroup group{PETSC_COMM_WORLD, "test"};
  double value = 1.0;
  group.real("-beam_test_length", value, "m", positive(), "text");
  {
    const Option option{"-beam_test_lenght", "3"};
    expect_parts(refusal([] { check_unknown_options(PETSC_COMM_WORLD); }), {"-beam_test_lenght", "-beam_test_length"});
  }
  const Option other{"-some_other_package", "3"};
  check_unknown_options(PETSC_COMM_WORLD);
}

TEST(Options, GiveMessagesOfTheLibraryTheKeysOfTheirQuantities) {
  OptionGroup group{PETSC_COMM_WORLD, "test"};
  double value = 1.0;
  group.real("-beam_test_depth", value, "m", positive(), "text");
  group.real("-beam_test_slope", value, "-", positive(), "text");
  EXPECT_EQ(with_option_keys("beam test depth: -3 is not allowed"), "option -beam_test_depth: -3 is not allowed");
  EXPECT_EQ(with_option_keys("beam test depth, beam test slope: 'a: b'"),
            "options -beam_test_depth, -beam_test_slope: 'a: b'");
  EXPECT_EQ(with_option_keys("ts type: `beam test slope` 2, `beam test sloop` 1"),
            "option -ts_type: -beam_test_slope 2, `beam test sloop` 1");
  for (const char* other :
       {"beam test depht: -3", "beam test depth", "beam test depth, other: 3", "", ": `", "`a` `b"}) {
    EXPECT_EQ(with_option_keys(other), other);
  }
}

TEST(Range, TellsItsBounds) {
  EXPECT_TRUE(between(0.0, 1.0).contains(1.0));
  EXPECT_FALSE(between(0.0, 1.0).contains(1.0 + 1e-15));
  EXPECT_FALSE(any().contains(std::nan("")));
  EXPECT_FALSE(any().contains(std::numeric_limits<double>::infinity()));
  EXPECT_EQ(between(0.0, 1.0).text(), "from 0 to 1");
}

}  // namespace
}  // namespace udar::petsc
