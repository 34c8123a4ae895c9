// See doctor.h.
#include "server/system/doctor.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>

namespace hapticd {
namespace {

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

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      std::array<char, 8> code{};
      std::snprintf(code.data(), code.size(), "\\u%04x", static_cast<unsigned>(c));
      out += code.data();
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string machine_of(const HostFacts& facts) {
  std::string text = facts.processor.empty() ? "unknown processor" : facts.processor;
  if (!facts.processors.empty()) text += " x " + std::to_string(facts.processors.size());
  if (facts.hypervisor) text += ", virtual";
  if (!facts.kernel.empty()) text += ", " + facts.kernel;
  return text;
}

/// As a JSON object, us.
std::string quantiles(const LatencyHistogram& histogram) {
  const LatencySummary summary = summarise(histogram);
  return "{\"p50\": " + format_us(summary.p50_ns) + ", \"p99\": " + format_us(summary.p99_ns) +
         ", \"p99.9\": " + format_us(summary.p99_9_ns) + ", \"max\": " + format_us(summary.max_ns) +
         "}";
}

double rate_of(const HostReport& report) {
  return 1e9 / static_cast<double>(report.timer.period_ns);
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
  return text + (fit(findings) ? "fit for hapticd\n" : "not fit for hapticd: see each cause\n");
}

std::string doctor_json(const HostReport& report, const std::vector<Finding>& findings) {
  const TimerMeasurement& timer = report.timer;
  std::string text = "{\"fit\": " + std::string(fit(findings) ? "true" : "false");
  text += ", \"machine\": " + quoted(machine_of(report.facts));
  text += ", \"seconds\": " + format_number(report.seconds);
  text += ", \"rate_hz\": " + format_number(rate_of(report));
  text += ", \"fifo\": " + std::string(timer.fifo ? "true" : "false");
  text += ", \"locked\": " + std::string(timer.locked ? "true" : "false");
  text += ", \"refused\": " + quoted(timer.refused);
  text += ", \"ticks\": " + std::to_string(timer.ticks);
  text += ", \"lost\": " + std::to_string(timer.skipped);
  text += ", \"held_up\": " + std::to_string(timer.held_up);
  text += ", \"late_us\": " + quantiles(timer.late);
  text += ", \"work_us\": " + quantiles(timer.work);
  text += ", \"findings\": [";
  for (const Finding& finding : findings) {
    text += std::string(&finding == findings.data() ? "" : ", ") +
            "{\"verdict\": " + quoted(word_of(finding.verdict)) +
            ", \"name\": " + quoted(finding.name) + ", \"what\": " + quoted(finding.what) +
            ", \"fix\": " + quoted(finding.fix) + "}";
  }
  return text + "]}\n";
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
  app.add_option("--seconds", timer.seconds, "how long to measure; 0: only look (10)")
      ->check(CLI::Range(0.0, 3600.0))
      ->type_name("N");
  app.add_option("--rate", rate, "ticks per second, 250 to 10000 (1000)")
      ->check(CLI::Range(250.0, 10000.0))
      ->type_name("HZ");
  app.add_option("--cpu", report.cpu, "processor to measure on (any)")->type_name("N");
  app.add_flag("--json", json, "the report as one JSON object, for programs");
  app.add_option("--root", root.root, "where proc, sys and dev are")->group("");
  app.footer("Exit codes: 0 fit, 2 bad command line, 6 causes were named.");
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
