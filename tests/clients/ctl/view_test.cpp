// What is shown of a daemon fits the terminal and says what matters.
#include "clients/ctl/view.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <utility>

namespace hapticd::test {

using namespace hapticd::ctl;

namespace {

View busy() {
  View view;
  view.server = "127.0.0.1:47800";
  view.scene.mutable_scene()->set_name("guqin");
  view.scene.mutable_scene()->add_tools()->set_name("hand");
  view.scene.mutable_scene()->add_strings()->set_name("C2");
  view.scene.mutable_scene()->add_bodies()->set_name("table");
  view.scene.set_server_version("0.1.0");
  view.scene.set_rate_hz(1000);
  view.has_state = true;
  v1::State& state = view.state;
  state.set_tick(12345);
  state.set_t_ns(12'345'000'000);
  state.set_loop_state(v1::LOOP_STATE_FAULT);
  state.set_cause(v1::CAUSE_INPUT_STALE);
  v1::ToolState& tool = *state.add_tools();
  for (const double x : {0.44, 0.01, -0.02}) tool.add_p_wh_m(x);
  for (const float f : {3.0F, 4.0F, 0.0F, 0.0F, 0.0F, 0.01F}) tool.add_wrench_h_w(f);
  tool.add_flags(v1::TOOL_FLAG_SATURATED);
  state.mutable_timing()->set_p99_ns(21'500);
  state.mutable_timing()->set_overruns(7);
  v1::ContactPatch& contact = *state.add_contacts();
  contact.set_body_index(0);
  for (const float f : {0.0F, 0.5F, 0.0F}) contact.add_force_w_n(f);
  v1::StringState& string = *state.add_strings();
  string.set_phase(v1::STRING_PHASE_RINGING);
  v1::Tone tone;
  tone.set_t_ns(12'245'000'000);
  tone.set_frequency_hz(65.4F);
  view.tones.push_front(tone);
  for (int i = 0; i < 100; ++i) view.ticks.add(5'000);
  view.lease.set_fence(3);
  view.lease.set_holder("player");
  view.lease.set_key_name("stage");
  return view;
}

bool says(const std::vector<std::string>& lines, const std::string& words) {
  return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
    return line.find(words) != std::string::npos;
  });
}

}  // namespace

TEST_CASE("the summary says who controls also before the first tick, and from whom and why") {
  View view;
  view.lease.set_fence(3);
  view.lease.set_holder("player");
  view.lease.set_taken_from("desk");
  view.lease.set_reason("lunch is over");
  CHECK(says(summary_lines(view), "of player, taken over from desk: lunch is over"));
}

TEST_CASE("the summary names scene, state, cause, force, times and who controls") {
  const std::vector<std::string> lines = summary_lines(busy());
  for (const char* words :
       {"scene guqin", "1000 Hz", "fault (input stale)", "force  5.000 N", "440.00", "saturated",
        "p99 21.5", "overruns 7", "of player, with the key stage", "tick 12345, 12.345 s"}) {
    CAPTURE(words);
    CHECK(says(lines, words));
  }
}

TEST_CASE("the screen adds contacts, strings, tones and the histogram by their names") {
  const std::vector<std::string> lines = screen_lines(busy(), 200, 100);
  for (const char* words : {"table", "0.500 N", "C2", "ringing", "65.40 Hz", "0.1 s ago", "< ",
                            "8 us      100", "q quits"}) {
    CAPTURE(words);
    CHECK(says(lines, words));
  }
}

TEST_CASE(
    "the quality is shown with its reason, and the work of the tick with what it was allowed") {
  View view = busy();
  v1::QualityState& quality = *view.state.mutable_quality();
  quality.set_level(3);
  quality.set_reason(v1::QUALITY_REASON_CHOSEN);
  quality.set_work(1804);
  quality.set_substeps(2);
  quality.set_sphere_tests(950);
  quality.set_qp_iterations(7);
  CHECK(says(summary_lines(view), "level 3, as asked for"));
  CHECK(says(summary_lines(view), "work       1804, no bound   2 sub-steps  950 tests  7 QP"));
  CHECK_FALSE(says(summary_lines(view), "cut short"));
  quality.set_automatic(true);
  quality.set_work_budget(2000);
  quality.set_cut_short(true);
  CHECK(says(summary_lines(view), "work       1804 of 2000   2 sub-steps"));
  quality.set_budget_us(62.5F);
  CHECK(says(summary_lines(view), "work       1804 of 2000 (62.5 us)   2 sub-steps"));
  CHECK(says(summary_lines(view), "cut short"));
  for (const auto& [reason, words] :
       {std::pair{v1::QUALITY_REASON_ROOM, "level 3 (auto), the budget leaves room"},
        std::pair{v1::QUALITY_REASON_BUDGET, "level 3 (auto), ticks came near the budget"},
        std::pair{v1::QUALITY_REASON_SETTLING, "level 3 (auto), waits before it changes again"}}) {
    quality.set_reason(reason);
    CHECK(says(summary_lines(view), words));
  }
}

TEST_CASE("a clamp of the stiffness is shown, and said to be hardly felt below a twentieth") {
  View view = busy();
  v1::StiffnessState& stiffness = *view.state.add_stiffness();
  const auto shown = [&](float scale, float bound) {
    stiffness.set_scale(scale);
    stiffness.set_bound_n_per_m(bound);
    return summary_lines(view);
  };
  CHECK_FALSE(says(shown(1.0F, 1000.0F), "clamped"));
  CHECK(says(shown(0.25F, 250.0F), "clamped to 25 %: the device bears 250 N/m"));
  CHECK_FALSE(says(shown(0.051F, 51.0F), "hardly"));
  CHECK(
      says(shown(0.034F, 71.4F), "clamped to 3.4 %: the device bears 71.4 N/m; hardly any force"));
  CHECK(says(shown(1e-9F, 0.0F), "clamped to 1e-07 %: the device bears 0 N/m; hardly any force"));
}

TEST_CASE("what a server does not say about its quality is not made up") {
  View view = busy();
  CHECK_FALSE(says(summary_lines(view), "quality"));
  CHECK_FALSE(says(summary_lines(view), "work"));
  view.state.mutable_quality()->set_level(1);
  const std::vector<std::string> lines = summary_lines(view);
  CHECK(std::count(lines.begin(), lines.end(), "quality    level 1") == 1);
}

TEST_CASE("whatever the size of the terminal, no line is longer and there are no more lines") {
  View view = busy();
  for (int i = 0; i < 200; ++i) *view.state.add_strings() = view.state.strings(0);
  view.silence_s = 3.0;
  CHECK(says(screen_lines(view, 80, 24), "nothing heard for 3 s"));
  for (const std::size_t columns : {1U, 20U, 80U, 300U}) {
    for (const std::size_t rows : {1U, 2U, 24U, 400U}) {
      const std::vector<std::string> lines = screen_lines(view, columns, rows);
      CHECK(lines.size() <= rows);
      for (const std::string& line : lines) CHECK(line.size() <= columns);
    }
  }
}

TEST_CASE("before the first tick there is a head and nothing else, and nothing breaks") {
  View view;
  CHECK(summary_lines(view).size() == 1);
  view.has_state = true;
  view.state.add_tools();
  view.state.add_contacts();
  view.state.add_strings()->set_string_index(9);
  view.state.add_stiffness();
  CHECK(!screen_lines(view, 80, 24).empty());
}

TEST_CASE("what touches a thing that the scene does not have is shown all the same") {
  View view = busy();
  view.tones.front().set_string_index(0xffffffffU);
  for (const std::uint32_t index : {1U, 0x7fffffffU, 0x80000000U, 0xffffffffU}) {
    CAPTURE(index);
    view.state.mutable_contacts(0)->set_string_index(index);
    view.state.mutable_strings(0)->set_string_index(index);
    const std::string name = ("string " + std::to_string(index)).substr(0, 12);
    CHECK(says(screen_lines(view, 80, 400), "contact    " + name));
    view.state.mutable_contacts(0)->set_body_index(index);
    CHECK(says(screen_lines(view, 80, 400), "contact    body"));
    view.state.mutable_contacts(0)->set_line_index(index);
    CHECK(says(screen_lines(view, 80, 400), "contact    line"));
  }
}

TEST_CASE("a tick falls into the bin of its power of two, the slowest into the last") {
  TickHistogram histogram;
  for (const std::uint32_t ns : {0U, 999U}) histogram.add(ns);
  histogram.add(1000);
  histogram.add(1999);
  histogram.add(2000);
  histogram.add(4'000'000'000U);
  CHECK(histogram.counts[0] == 2);
  CHECK(histogram.counts[1] == 2);
  CHECK(histogram.counts[2] == 1);
  CHECK(histogram.counts.back() == 1);
}

}  // namespace hapticd::test
