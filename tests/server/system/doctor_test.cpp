// The doctor's report and its program. Truth: the numbers put in, JSON's own rules, and a period
// that a timer cannot run faster than.
#include "server/system/doctor.h"

#include <doctest/doctest.h>

#include <array>

#include "tests/server/system/made_up_machine.h"

namespace hapticd::test {
namespace {

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

HostReport some_report() {
  HostReport report;
  report.seconds = 2.0;
  report.timer.ticks = 1999;
  report.timer.skipped = 1;
  record(report.timer.late, 100);
  report.facts.processor = "A \"quoted\\\" processor\t";
  report.facts.processors = {0, 1};
  return report;
}

TEST_CASE("the text says for each cause what it is and what to do, and the verdict comes last") {
  const HostReport report = some_report();
  const std::vector<Finding> findings{{Verdict::kGood, "idle", "awake", ""},
                                      {Verdict::kCause, "memlock", "too little", "raise it"}};
  const std::string text = doctor_text(report, findings);
  CHECK(has(text, "1000 Hz for 2 s"));
  CHECK(has(text, "1 ticks lost"));
  CHECK(has(text, "cause  memlock"));
  CHECK(has(text, "too little\n"));
  CHECK(has(text, "-> raise it\n"));
  CHECK(text.ends_with("\nThis machine is not fit for hapticd yet: mend each cause above.\n"));
  CHECK(doctor_text(report, {findings[0]}).ends_with("\nThis machine is fit for hapticd.\n"));
}

TEST_CASE("the JSON escapes what JSON must not contain and says whether the machine is fit") {
  const HostReport report = some_report();
  const std::string text = doctor_json(report, {{Verdict::kCause, "idle", "a\nb", "c"}});
  CHECK(has(text, R"("machine":"A \"quoted\\\" processor\t x 2")"));
  CHECK(has(text, R"("fit":false)"));
  CHECK(has(text, R"("late_us":{"p50":0.1,)"));
  CHECK(has(text, R"({"verdict":"cause","name":"idle","what":"a\nb","fix":"c"})"));
  CHECK(has(doctor_json(report, {}), R"("fit":true)"));
}

TEST_CASE("a measurement runs one tick a period and counts every one") {
  TimerOptions options;
  options.seconds = 0.05;
  options.period_ns = 500'000;
  const TimerMeasurement timer = measure_timer(options);
  CHECK(timer.ticks + timer.skipped >= 99);
  CHECK(timer.ticks <= 100);
  CHECK(timer.late.total == timer.ticks);
  CHECK(timer.work.total == timer.ticks);
  CHECK(summarise(timer.work).p50_ns > 0);
  CHECK((timer.refused.empty() || !timer.fifo || !timer.locked));
}

TEST_CASE("the program refuses what makes no sense, and needs no daemon for what it says") {
  const std::array<const char*, 3> bad{"doctor", "--seconds", "-1"};
  CHECK(run_doctor(3, bad.data()) == kDoctorUsage);
  const std::array<const char*, 2> unknown{"doctor", "--bogus"};
  CHECK(run_doctor(2, unknown.data()) == kDoctorUsage);
  const MadeUpMachine machine;
  const std::string root = machine.root().root.string();
  const std::array<const char*, 6> look{"doctor", "--seconds", "0",
                                        "--json", "--root",    root.c_str()};
  CHECK(run_doctor(6, look.data()) == kDoctorFit);
  machine.write("sys/devices/system/cpu/online", "0\n");
  CHECK(run_doctor(6, look.data()) == kDoctorUnfit);
}

}  // namespace
}  // namespace hapticd::test
