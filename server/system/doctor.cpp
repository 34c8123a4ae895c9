// See doctor.h.
#include "server/system/doctor.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "proto/hints/command_line_fault.h"
#include "proto/hints/quantity.h"
#include "proto/hints/whole_number_option.h"

namespace hapticd {
namespace {

/// Of the numbers of processors, as the kernel may have them.
constexpr std::uint64_t kMaxCpu = 1023;

using Json = nlohmann::ordered_json;

const char* word_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood:
      return "good";
    case Verdict::kHint:
      return "hint";
    case Verdict::kCause:
      break;
  }
  return "cause";
}

std::string format_us(std::int64_t ns) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f", 1e-3 * static_cast<double>(ns));
  return text.data();
}

std::string format_number(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", number);
  return text.data();
}

std::string machine_of(const HostFacts& facts) {
  std::string text = facts.processor.empty() ? "unknown processor" : facts.processor;
  if (!facts.processors.empty()) text += " x " + std::to_string(facts.processors.size());
  if (facts.hypervisor) text += ", virtual";
  if (!facts.kernel.empty()) text += ", " + facts.kernel;
  return text;
}

/// In us, to a tenth.
Json json_of(const LatencyHistogram& histogram) {
  const LatencySummary summary = summarise(histogram);
  const auto us = [](std::int64_t ns) { return std::round(1e-2 * static_cast<double>(ns)) / 10.0; };
  return {{"p50", us(summary.p50_ns)},
          {"p99", us(summary.p99_ns)},
          {"p99.9", us(summary.p99_9_ns)},
          {"max", us(summary.max_ns)}};
}

double rate_of(const HostReport& report) {
  return 1e9 / static_cast<double>(report.timer.period_ns);
}

/// The number of `option` may have a unit of the kind of `unit`, in which it is read.
CLI::Option* in_unit(CLI::Option* option, const char* unit) {
  const auto read = [unit](std::string& text) -> std::string {
    const hints::Quantity quantity = hints::parse_quantity(text, unit);
    if (!quantity.fault.empty()) {
      return (text.find(',') == std::string::npos ? text + " cannot be read. " : "") +
             quantity.fault;
    }
    std::array<char, 32> number{};
    std::snprintf(number.data(), number.size(), "%.17g", quantity.value);
    text = number.data();
    return {};
  };
  return option->transform(CLI::Validator(read, ""));
}

}  // namespace

std::string doctor_text(const HostReport& report, const std::vector<Finding>& findings) {
  std::string text = machine_of(report.facts) + "\n";
  if (report.seconds > 0.0) {
    const LatencySummary late = summarise(report.timer.late);
    text += "a timer at " + format_number(rate_of(report)) + " Hz for " +
            format_number(report.seconds) + " s, " +
            (report.timer.fifo ? "SCHED_FIFO" : "without SCHED_FIFO") + ": late by p50 " +
            format_us(late.p50_ns) + ", p99 " + format_us(late.p99_ns) + ", p99.9 " +
            format_us(late.p99_9_ns) + ", max " + format_us(late.max_ns) + " us; " +
            std::to_string(report.timer.skipped) + " ticks lost\n";
  }
  for (const Finding& finding : findings) {
    std::array<char, 32> head{};
    std::snprintf(head.data(), head.size(), "%-5s  %-13s  ", word_of(finding.verdict),
                  finding.name.c_str());
    text += head.data() + finding.what + "\n";
    if (!finding.fix.empty()) text += std::string(22, ' ') + "-> " + finding.fix + "\n";
  }
  return text + (fit(findings)
                     ? "This machine is fit for hapticd.\n"
                     : "This machine is not fit for hapticd yet: mend each cause above.\n");
}

std::string doctor_json(const HostReport& report, const std::vector<Finding>& findings) {
  const TimerMeasurement& timer = report.timer;
  Json json = {{"fit", fit(findings)},
               {"machine", machine_of(report.facts)},
               {"seconds", report.seconds},
               {"rate_hz", rate_of(report)},
               {"fifo", timer.fifo},
               {"locked", timer.locked},
               {"refused", timer.refused},
               {"ticks", timer.ticks},
               {"lost", timer.skipped},
               {"held_up", timer.held_up},
               {"late_us", json_of(timer.late)},
               {"work_us", json_of(timer.work)},
               {"findings", Json::array()}};
  for (const Finding& finding : findings) {
    json["findings"].push_back({{"verdict", word_of(finding.verdict)},
                                {"name", finding.name},
                                {"what", finding.what},
                                {"fix", finding.fix}});
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

int run_doctor(int argc, const char* const* argv) {
  HostReport report;
  TimerOptions timer;
  ProbeRoot root;
  double rate = 1000.0;
  bool json = false;
  CLI::App app(
      "Measures this machine with a bare timer loop of the daemon's own policy and names what "
      "makes ticks late, each cause with the command that fixes it. Needs no privilege and no "
      "running daemon.",
      "hapticd doctor");
  in_unit(app.add_option("--seconds", timer.seconds, "how long to measure; 0: only look (10)"), "s")
      ->check(CLI::Range(0.0, 3600.0))
      ->type_name("N");
  in_unit(app.add_option("--rate", rate, "ticks per second, 250 to 10000 (1000)"), "Hz")
      ->check(CLI::Range(250.0, 10000.0))
      ->type_name("HZ");
  hints::takes_whole_number(app.add_option("--cpu", report.cpu, "processor to measure on (any)"), 0,
                            kMaxCpu)
      ->type_name("N");
  app.add_flag("--json", json, "the report as one JSON object, for programs");
  app.add_option("--root", root.root, "where proc, sys and dev are")->group("");
  app.footer("Exit codes: 0 fit, 2 bad command line, 6 causes were named.");
  app.failure_message(hints::failure_message);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDoctorFit : kDoctorUsage;
  }
  timer.period_ns = std::llround(1e9 / rate);
  timer.cpu = report.cpu;
  report.seconds = timer.seconds;
  report.facts = read_facts(root);
  report.before = read_counters(root, report.cpu);
  report.timer = measure_timer(timer);
  report.after = read_counters(root, report.cpu);
  const std::vector<Finding> findings = diagnose(report);
  const std::string text = json ? doctor_json(report, findings) : doctor_text(report, findings);
  std::fputs(text.c_str(), stdout);
  return fit(findings) ? kDoctorFit : kDoctorUnfit;
}

}  // namespace hapticd
