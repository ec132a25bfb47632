// ranks: 1; size: short
/// @file
/// The arithmetic of convergence studies: orders, limits and budgets of made-up sequences, plans of runs, and what is
/// read off a motion.

#include <gtest/gtest.h>
#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "tools/design_report.hpp"
#include "tools/study_analysis.hpp"
#include "tools/study_design.hpp"
#include "tools/study_plan.hpp"
#include "tools/study_quantities.hpp"
#include "udar/petsc/error.hpp"

namespace {

using namespace udar;
using namespace udar::study;
using Numbers = std::vector<double>;

/// limit + c h^p at the given sizes.
Numbers power_law(const Numbers& sizes, double limit, double c, double p) {
  Numbers values;
  for (const double h : sizes) {
    values.push_back(limit + c * std::pow(h, p));
  }
  return values;
}

TEST(Trend, FindsOrderAndLimitOfAPowerAtAnyRatioOfSizes) {
  for (const Numbers& sizes : {Numbers{1.0 / 20, 1.0 / 40, 1.0 / 80}, Numbers{1.0 / 20, 1.0 / 30, 1.0 / 80},
                               Numbers{1e-1, 2e-2, 1e-2}, Numbers{0.4, 0.3, 0.2, 0.1, 0.05}}) {
    for (const double p : {0.6, 1.0, 2.0, 3.5}) {
      for (const double c : {5.0, -5.0}) {
        const Trend found = trend(sizes, power_law(sizes, 3.0, c, p), 0.0);
        ASSERT_EQ(found.verdict, Verdict::converges) << p;
        EXPECT_EQ(found.bound, Bound::estimate);
        for (const auto& order : found.orders) {
          // The last change, 5e-6 at the least (p = 3.5 down to 1e-2), is known to an ulp of 3, 4e-16.
          EXPECT_NEAR(order.value_or(-1.0), p, 1e-6) << p;
        }
        const double error = 5.0 * std::pow(sizes.back(), p);
        EXPECT_NEAR(found.limit.value_or(0.0), 3.0, 1e-6 * error + 1e-14);
        EXPECT_NEAR(found.error, error, 1e-6 * error + 1e-14);
      }
    }
  }
}

TEST(Trend, SaysWhereNothingIsMonotone) {
  const Numbers sizes{8.0, 4.0, 2.0, 1.0};
  for (const Numbers& values :
       {Numbers{1.0, 2.0, 1.5, 1.75}, Numbers{1.0, 2.0, 3.0, 2.5}, Numbers{2.0, 1.0, 1.5, 1.75}}) {
    const Trend found = trend(sizes, values, 0.0);
    EXPECT_EQ(found.verdict, Verdict::not_monotone);
    EXPECT_FALSE(found.limit.has_value());
    EXPECT_EQ(found.bound, Bound::changes);
    EXPECT_DOUBLE_EQ(found.error, *std::ranges::max_element(values) - *std::ranges::min_element(values));
  }
  // What a coarse value does before the last four does not matter.
  const Trend late = trend(Numbers{16.0, 8.0, 4.0, 2.0, 1.0}, Numbers{9.0, 11.0, 7.0, 5.0, 4.0}, 0.0);
  EXPECT_EQ(late.verdict, Verdict::converges);
  EXPECT_DOUBLE_EQ(*late.limit, 3.0);  // changes 4, 2, 1 under halving: first order
}

TEST(Trend, DoesNotExtrapolateNoise) {
  // Second order spoilt by a tenth of the last change: the order is no longer steady, or no longer there.
  const Numbers sizes{8.0, 4.0, 2.0, 1.0};
  Numbers values = power_law(sizes, 1.0, 1.0, 2.0);
  values.back() += 2.6;
  const Trend found = trend(sizes, values, 0.0);
  EXPECT_EQ(found.verdict, Verdict::irregular);
  EXPECT_FALSE(found.limit.has_value());
  EXPECT_EQ(found.bound, Bound::changes);
  EXPECT_GE(found.error, std::abs(values.back() - 1.0));
}

TEST(Trend, SaysWhatDoesNotConverge) {
  const Numbers sizes{4.0, 2.0, 1.0};
  const Trend grows = trend(sizes, Numbers{0.25, 0.42, 0.69}, 0.0);  // a point support sinking under refinement
  EXPECT_EQ(grows.verdict, Verdict::diverges);
  EXPECT_EQ(grows.bound, Bound::at_least);
  EXPECT_DOUBLE_EQ(grows.error, 0.69 - 0.42);
  EXPECT_EQ(trend(sizes, power_law(sizes, 1.0, 1.0, -1.0), 0.0).verdict, Verdict::diverges);
  EXPECT_EQ(trend(sizes, Numbers{3.0, 2.0, 1.0}, 0.0).verdict, Verdict::diverges);  // like log h
  const Trend slow = trend(sizes, power_law(sizes, 1.0, 1.0, 0.3), 0.0);
  EXPECT_EQ(slow.verdict, Verdict::slow);
  EXPECT_FALSE(slow.limit.has_value());
  // The true error is larger than the last change, as "at least" says.
  EXPECT_EQ(slow.bound, Bound::at_least);
  EXPECT_LT(slow.error, 1.0);
}

TEST(Trend, DoesNotExtrapolateFarBeyondZero) {
  const Numbers sizes{4.0, 2.0, 1.0};
  const Trend vanishes = trend(sizes, power_law(sizes, 0.0, 2.0, 1.0), 0.0);
  EXPECT_EQ(vanishes.verdict, Verdict::converges);
  EXPECT_NEAR(vanishes.limit.value_or(1.0), 0.0, 1e-14);
  const Trend beyond = trend(sizes, power_law(sizes, -1.5, 2.0, 1.0), 0.0);  // a limit of -1.5 from a value of 0.5
  EXPECT_EQ(beyond.verdict, Verdict::slow);
  EXPECT_FALSE(beyond.limit.has_value());
}

TEST(Trend, KnowsRoundOff) {
  const Numbers sizes{4.0, 2.0, 1.0};
  EXPECT_EQ(trend(sizes, Numbers{0.0, 0.0, 0.0}, 0.0).verdict, Verdict::constant);
  EXPECT_EQ(trend(sizes, Numbers{1.0, 1.0 + 1e-15, 1.0 - 1e-15}, 0.0).verdict, Verdict::constant);
  EXPECT_EQ(trend(sizes, Numbers{1e-17, 3e-17, 2e-17}, 1.0).verdict, Verdict::constant);
  EXPECT_EQ(trend(sizes, Numbers{1e-17, 3e-17, 2e-17}, 0.0).verdict, Verdict::not_monotone);
  EXPECT_EQ(trend(sizes, Numbers{1.0, 2.0, 2.0}, 0.0).verdict, Verdict::settled);
  EXPECT_EQ(trend(sizes, power_law(sizes, 1.0, 1e-3, 9.0), 0.0).verdict, Verdict::settled);
}

TEST(Trend, OfFewValues) {
  EXPECT_EQ(trend({}, {}, 1.0).bound, Bound::unknown);
  EXPECT_EQ(trend(Numbers{1.0}, Numbers{2.0}, 1.0).verdict, Verdict::no_values);
  const Trend two = trend(Numbers{2.0, 1.0}, Numbers{2.0, 2.5}, 1.0);
  EXPECT_EQ(two.verdict, Verdict::two_values);
  EXPECT_EQ(two.bound, Bound::changes);
  EXPECT_DOUBLE_EQ(two.error, 0.5);
}

TEST(Budget, AddsItsPartsAndCorrectsOnlyWhereAllConverge) {
  // q = 7 + 3 h^2 - 2 k: the limit is reached along both axes together, the errors are those of the finest run.
  const Numbers h{0.4, 0.2, 0.1};
  const Numbers k{0.3, 0.2, 0.1};
  const double finest = 7.0 + 0.03 - 0.2;
  const Trend along_h = trend(h, power_law(h, 7.0 - 0.2, 3.0, 2.0), 0.0);
  const Trend along_k = trend(k, power_law(k, 7.0 + 0.03, -2.0, 1.0), 0.0);
  const Budget both = budget(finest, std::vector{along_h, along_k});
  EXPECT_EQ(both.bound, Bound::estimate);
  EXPECT_NEAR(both.limit, 7.0, 1e-12);
  EXPECT_NEAR(both.sum, 0.03 + 0.2, 1e-12);
  const Trend open = trend(Numbers{4.0, 2.0, 1.0}, Numbers{1.0, 2.0, 4.0}, 0.0);
  const Budget three = budget(finest, std::vector{along_h, open, along_k});
  EXPECT_EQ(three.bound, Bound::at_least);
  EXPECT_DOUBLE_EQ(three.limit, finest);
  EXPECT_NEAR(three.sum, 0.23 + 2.0, 1e-12);
  EXPECT_DOUBLE_EQ(budget(finest, {}).limit, finest);
}

/// A ball-like beam of mass centre y0 - g t^2 / 2 that is turned round at its first contact with the share e of its
/// speed, over a contact in which it moves evenly.
std::vector<Sample> bounce(double share, double row, double contact, double duration) {
  constexpr double kGravity = 10.0;
  const double impact = kGravity * contact;
  std::vector<Sample> samples;
  for (int i = 0; i * row < 1.5; ++i) {
    const double t = i * row;
    Sample sample;
    sample.time = t;
    if (t <= contact) {
      sample.velocity = -kGravity * t;
      sample.height = 1.0 - 0.5 * kGravity * t * t;
    } else {
      const double part = std::min(1.0, (t - contact) / duration);
      const double flight = t - contact - part * duration;
      const double reached = -impact + part * (1.0 + share) * impact;
      sample.velocity = reached - kGravity * flight;
      sample.height = 1.0 - 0.5 * impact * contact + 0.5 * (reached - impact) * part * duration + reached * flight -
                      0.5 * kGravity * flight * flight;
    }
    samples.push_back(sample);
  }
  return samples;
}

TEST(Rebound, IsTheSpeedAtTheHeightOfTheFirstContact) {
  for (const double row : {1e-3, 7.3e-3}) {
    const double contact = 0.4;
    const double duration = 0.02;
    const std::vector<Sample> samples = bounce(0.7, row, contact, duration);
    const app::Rebound found = rebound(samples, contact, 10.0);
    // At the end of the contact the beam is below by the mean speed of the contact times its duration.
    const double below = 0.5 * (1.0 - 0.7) * 4.0 * duration;
    EXPECT_NEAR(found.velocity.value_or(0.0), std::sqrt(2.8 * 2.8 - 2.0 * 10.0 * below), 1e-12) << row;
    EXPECT_GE(*found.contact_time, duration - 1e-12);
    EXPECT_LE(*found.contact_time, duration + row);
  }
}

TEST(Rebound, IsEmptyWithoutOne) {
  const std::vector<Sample> samples = bounce(0.7, 1e-3, 0.4, 0.02);
  EXPECT_FALSE(rebound(samples, 2.0, 10.0).velocity.has_value());
  EXPECT_FALSE(rebound({}, 0.4, 10.0).velocity.has_value());
  EXPECT_FALSE(rebound(std::span{samples}.first(405), 0.4, 10.0).velocity.has_value());  // still going down
}

TEST(Samples, FillEachStratumOnce) {
  for (const std::size_t count : {std::size_t{1}, std::size_t{7}, std::size_t{1000}}) {
    const Variable variable{.key = "x", .values = {}, .range = {2.0, 5.0}};
    std::vector<std::size_t> strata;
    for (const std::string& value : sampled(variable, Sampling::latin, count, 3, 0)) {
      strata.push_back(static_cast<std::size_t>((std::stod(value) - 2.0) / 3.0 * static_cast<double>(count)));
    }
    EXPECT_GE(std::ranges::count(strata, strata.front()), 1);
    std::ranges::sort(strata);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(strata[i], i);
    }
  }
}

TEST(Samples, AreThoseOfTheSeedAndTheVariable) {
  const Variable variable{.key = "x", .values = {}, .range = {1e6, 1e9}, .logarithmic = true};
  for (const Sampling sampling : {Sampling::latin, Sampling::random}) {
    const auto first = sampled(variable, sampling, 20, 1, 0);
    EXPECT_EQ(first, sampled(variable, sampling, 20, 1, 0));
    EXPECT_NE(first, sampled(variable, sampling, 20, 2, 0));
    EXPECT_NE(first, sampled(variable, sampling, 20, 1, 1));
  }
}

TEST(RankCorrelation, FollowsOrderAlone) {
  const std::vector<double> x{1.0, 2.0, 3.0, 4.0};
  EXPECT_DOUBLE_EQ(*rank_correlation(x, std::vector{1.0, 10.0, 100.0, 1e6}), 1.0);
  EXPECT_DOUBLE_EQ(*rank_correlation(x, std::vector{4.0, 1.0, 0.5, -7.0}), -1.0);
  // Ranks 1, 2.5, 2.5, 4 against 1, 2, 3, 4: 4.5 / sqrt(5 4.5).
  EXPECT_DOUBLE_EQ(*rank_correlation(x, std::vector{0.0, 1.0, 1.0, 2.0}), 4.5 / std::sqrt(22.5));
  EXPECT_FALSE(rank_correlation(x, std::vector{1.0, 1.0, 1.0, 1.0}).has_value());
}

TEST(Largest, IsThatOfTheParabola) {
  std::vector<Sample> samples(40);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].time = static_cast<double>(i);
    samples[i].height = std::sin(0.1 * static_cast<double>(i) + 0.03);
  }
  // Half a row h = 0.1 from the peak the parabola of a sine is off by 3 h^4 / 128.
  EXPECT_NEAR(largest(samples, [](const Sample& row) { return row.height; }), 1.0, 2.4e-6);
  EXPECT_NEAR(-largest(std::span{samples}.first(3), [](const Sample& row) { return -row.height; }), std::sin(0.03),
              1e-15);
  // Of a parabola it is exact, also where the last row comes early.
  std::vector<Sample> uneven(3);
  for (const auto& [i, time] : {std::pair<std::size_t, double>{0, 0.0}, {1, 1.0}, {2, 1.3}}) {
    uneven[i].time = time;
    uneven[i].height = 2.0 - (time - 1.1) * (time - 1.1);
  }
  EXPECT_NEAR(largest(uneven, [](const Sample& row) { return row.height; }), 2.0, 1e-15);
}

TEST(Plan, GridOfAxesFromCoarseToFine) {
  const ScopedOptions options{
      {{"-filter_frequency", "400,100,200"}, {"-ts_rtol", "1e-10,1e-6"}, {"-beam_elements", "20"}}};
  std::vector<Series> series = read_series("");
  const std::vector<PlannedRun> runs = plan(series, {}, "out");
  ASSERT_EQ(series.size(), 1U);
  ASSERT_EQ(series[0].axes.size(), 2U);
  EXPECT_EQ(series[0].axes[0].key, "filter_frequency");
  EXPECT_EQ(series[0].axes[0].values, (std::vector<std::string>{"100", "200", "400"}));
  EXPECT_EQ(series[0].axes[0].sizes, (Numbers{1.0 / 100, 1.0 / 200, 1.0 / 400}));
  EXPECT_EQ(series[0].axes[1].values, (std::vector<std::string>{"1e-6", "1e-10"}));
  ASSERT_EQ(runs.size(), 6U);
  EXPECT_EQ(runs[5].at, (std::vector<std::size_t>{2, 1}));
  EXPECT_EQ(runs[5].options,
            (Options{{"-filter_frequency", "400"}, {"-ts_rtol", "1e-10"}, {"-output_directory", "out/run-005"}}));
  EXPECT_EQ(option_value("-filter_frequency"), "400,100,200");  // as it was
}

TEST(Plan, LinesThroughTheFinestOnly) {
  const ScopedOptions options{
      {{"-filter_frequency", "100,200,400"}, {"-beam_elements", "20,40,80"}, {"-ts_dt", "1e-3,1e-4"}}};
  std::vector<Series> series = read_series("");
  const std::vector<PlannedRun> runs = plan(series, {.axes = {}, .design = Design::lines}, "out");
  EXPECT_EQ(runs.size(), 1U + 2U + 2U + 1U);
}

TEST(Plan, SeriesOverlayTheCommandLine) {
  const ScopedOptions options{{{"-filter_frequency", "100,200"}, {"-support_position", "2,8"}}};
  std::vector<Series> series =
      read_series("points: ; line: -contact_surface line -filter_frequency 50,100,200; flag: -floor -beam_tension 3;");
  const std::vector<PlannedRun> runs = plan(series, {}, "out");
  ASSERT_EQ(series.size(), 3U);
  EXPECT_EQ(series[1].name, "line");
  EXPECT_EQ(runs.size(), 2U + 3U + 2U);
  EXPECT_EQ(runs[2].options,
            (Options{{"-contact_surface", "line"}, {"-filter_frequency", "50"}, {"-output_directory", "out/run-002"}}));
  EXPECT_EQ(series[2].options, (Options{{"-beam_tension", "3"}, {"-floor", std::nullopt}}));
}

TEST(Plan, RefinesSegments) {
  const ScopedOptions options{{{"-beam_length", "5,5"}, {"-beam_elements", "10,30"}, {"-study_refine", "1,2,4"}}};
  std::vector<Series> series = read_series("");
  const std::vector<PlannedRun> runs = plan(series, {}, "out");
  ASSERT_EQ(runs.size(), 3U);
  EXPECT_EQ(runs[2].options[0].second, "40,120");
}

TEST(Plan, FurtherAxesGoInTheirOwnDirection) {
  const ScopedOptions options{{{"-support_width", "1,0.5,0.25"}, {"-initial_height", "1,2"}}};
  std::vector<Series> series = read_series("");
  EXPECT_EQ(plan(series, {.axes = {"support_width", "initial_height"}, .design = Design::grid}, "out").size(), 6U);
  EXPECT_EQ(series[0].axes[0].sizes, (Numbers{1.0, 0.5, 0.25}));
  EXPECT_EQ(series[0].axes[1].sizes, (Numbers{1.0, 0.5}));
}

TEST(Plan, RefusesWhatMakesNoSense) {
  const auto refused = [](const Options& options, const Request& request, const std::string& text,
                          const std::string& expected) {
    const ScopedOptions in_force{options};
    try {
      std::vector<Series> series = read_series(text);
      static_cast<void>(plan(series, request, "out"));
      ADD_FAILURE() << "not refused: " << expected;
    } catch (const InputError& error) {
      EXPECT_NE(std::string{error.what()}.find(expected), std::string::npos) << error.what();
    }
  };
  refused({{"-filter_frequency", "100,,200"}}, {}, "", "-filter_frequency: ''");
  refused({{"-filter_frequency", "100,abc"}}, {}, "", "-filter_frequency: 'abc'");
  refused({{"-filter_frequency", "100,200,"}}, {}, "", "-filter_frequency: ''");
  refused({{"-filter_frequency", "100,-200"}}, {}, "", "'-200'");
  refused({{"-filter_frequency", "100,100"}}, {}, "", "must differ");
  refused({{"-support_width", "1,3,2"}}, {.axes = {"support_width"}, .design = Design::grid}, "", "coarse to fine");
  refused({}, {.axes = {"support_width"}, .design = Design::grid}, "", "-study_axes: -support_width");
  refused({{"-beam_length", "1,1"}, {"-beam_elements", "1,2"}}, {.axes = {"beam_elements"}, .design = Design::grid}, "",
          "-study_refine");
  refused({{"-beam_elements", "1,2"}, {"-study_refine", "1,2"}}, {}, "", "-study_refine");
  refused({{"-study_refine", "1,2.5"}}, {}, "", "'2.5'");
  refused({}, {}, "line", "-study_series: 'line'");
  refused({}, {}, "a: ; a: -floor", "'a' is taken");
  refused({}, {}, "own: -floor", "'own' is taken");
  refused({}, {}, "a: floor", "'floor'");
  refused({}, {}, "a: -study_ranks 2", "-study_ranks");
  refused({}, {}, ";", "no series");
}

TEST(Deal, GivesEachRunToOneGroupAndTheDearestFirst) {
  std::vector<PlannedRun> runs(7);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    runs[i].number = i;
    runs[i].cost = static_cast<double>(1 + i % 4);
  }
  const auto dealt = deal(runs, 3);
  std::multiset<std::size_t> all;
  for (const auto& group : dealt) {
    double last = 1e300;
    double load = 0.0;
    for (const std::size_t run : group) {
      all.insert(run);
      EXPECT_LE(runs[run].cost, last);
      last = runs[run].cost;
      load += runs[run].cost;
    }
    // 16 in all: no group has more than the mean and one run.
    EXPECT_LE(load, 16.0 / 3.0 + 4.0);
  }
  EXPECT_EQ(all, (std::multiset<std::size_t>{0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(dealt[0].front(), 3U);
}

}  // namespace
