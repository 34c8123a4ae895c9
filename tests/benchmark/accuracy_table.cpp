// What every option of the contact problem buys: forces over five contact sessions against a
// reference of 400 sub-steps, 4 mrad, tolerance 1e-10 m. Prints a markdown table: per session the
// rms error in percent of the rms force and the greatest error in mN; over all sessions the median
// time of a tick and the most sub-steps one took. One option at a time is changed, the others keep
// their default. --quick plays the first session only.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "tests/core/contact/rendering_fixture.h"
#include "tests/core/contact/session_run.h"

namespace hapticd::test {
namespace {

constexpr double kRate = 1000.0;
/// Rate of the reference for other rates: a common multiple of all of them.
constexpr int kFineRate = 8000;

/// A session with its references.
struct Judged {
  ContactSession session;
  std::vector<Vector3> reference;       ///< as the tick, 400 sub-steps
  std::vector<Vector3> reference_thin;  ///< with a skin of 1 um
  std::vector<Vector3> reference_fine;  ///< at kFineRate
};

Judged judge(ContactSession session) {
  ContactOptions thin = reference_options();
  thin.skin = 1e-6;
  return {session, play(session, reference_options(), kRate).f_H_W,
          play(session, thin, kRate).f_H_W, play(session, reference_options(), kFineRate).f_H_W};
}

/// Appends `value` with two digits, then `end`.
void append_number(std::string& line, double value, const char* end) {
  char text[32];
  if (value >= 1e-3) {
    std::snprintf(text, sizeof text, value >= 100.0 ? " %.0f%s" : " %.2g%s", value, end);
  } else {
    std::snprintf(text, sizeof text, " <0.001%s", end);
  }
  line += text;
}

/// One line of the table.
class Row {
 public:
  explicit Row(std::string name) : line_("| " + std::move(name) + " |") {}

  void add(const SessionRun& run, const ForceError& error) {
    append_number(line_, error.rms_percent, " /");
    append_number(line_, 1e3 * error.max_newton, " |");
    microseconds_.insert(microseconds_.end(), run.microseconds.begin(), run.microseconds.end());
    most_sub_steps_ = std::max(most_sub_steps_, run.most_sub_steps);
  }

  void print() {
    const auto middle =
        microseconds_.begin() + static_cast<std::ptrdiff_t>(microseconds_.size() / 2);
    std::nth_element(microseconds_.begin(), middle, microseconds_.end());
    std::printf("%s %.1f | %d |\n", line_.c_str(), *middle, most_sub_steps_);
    std::fflush(stdout);
  }

 private:
  std::string line_;
  std::vector<double> microseconds_;
  int most_sub_steps_ = 0;
};

using Reference = std::vector<Vector3> Judged::*;

void print_row(const std::vector<Judged>& sessions, const std::string& name,
               const ContactOptions& options, Reference reference = &Judged::reference) {
  Row row(name);
  for (const Judged& judged : sessions) {
    const SessionRun run = play(judged.session, options, kRate);
    row.add(run, force_error(run.f_H_W, judged.*reference));
  }
  row.print();
}

/// Rows of one option; `values` in multiples of `per_unit`.
template <typename Value>
void print_rows(const std::vector<Judged>& sessions, const char* name, const char* unit,
                Value per_unit, Value ContactOptions::*option, std::initializer_list<Value> values,
                Reference reference = &Judged::reference) {
  for (const Value value : values) {
    ContactOptions options;
    options.*option = value * per_unit;
    char cell[80];
    std::snprintf(cell, sizeof cell, "%s %g%s", name, static_cast<double>(value), unit);
    print_row(sessions, cell, options, reference);
  }
}

/// Ticks at another rate; `held`: the device keeps the force until the next tick, and every moment
/// counts, otherwise only the ticks do.
void print_rate(const std::vector<Judged>& sessions, int rate, bool held) {
  Row row("rate " + std::to_string(rate) + " Hz, " + (held ? "held to the next tick" : "at ticks"));
  const auto step = static_cast<std::size_t>(kFineRate / rate);
  for (const Judged& judged : sessions) {
    const SessionRun run = play(judged.session, ContactOptions{}, rate);
    std::vector<Vector3> force;
    std::vector<Vector3> reference;
    for (std::size_t k = 0; k < judged.reference_fine.size(); k += held ? 1 : step) {
      force.push_back(run.f_H_W[k / step]);
      reference.push_back(judged.reference_fine[k]);
    }
    row.add(run, force_error(force, reference));
  }
  row.print();
}

void print_table(const std::vector<Judged>& sessions) {
  std::printf("| option |");
  for (const Judged& judged : sessions) std::printf(" %s |", judged.session.name);
  std::printf(" median us | most sub-steps |\n|---|");
  for (std::size_t k = 0; k < sessions.size(); ++k) std::printf("---|");
  std::printf("---|---|\n");

  using Options = ContactOptions;
  print_row(sessions, "**defaults**", Options{});
  print_rows(sessions, "sub-steps", "", 1, &Options::sub_steps, {1, 2, 4, 8, 16, 24, 32});
  print_rows(sessions, "stop tolerance", " um", 1e-6, &Options::stop_tolerance,
             {100.0, 10.0, 1.0, 0.1, 0.01});
  print_rows(sessions, "rotation step", " mrad", 1e-3, &Options::rotation_step,
             {10.0, 20.0, 50.0, 100.0, 200.0});
  print_rows(sessions, "skin", " um against 1 um", 1e-6, &Options::skin,
             {0.0, 1.0, 5.0, 20.0, 100.0}, &Judged::reference_thin);
  print_rows(sessions, "margin", " mm", 1e-3, &Options::margin, {1.0, 2.0, 5.0, 10.0, 20.0});
  for (const bool held : {false, true}) {
    for (const int rate : {250, 500, 1000, 2000, 4000}) print_rate(sessions, rate, held);
  }
  print_rows(sessions, "tool tree cut at level", "", 1, &Options::tool_level, {1, 2});
  print_rows(sessions, "body tree cut at level", "", 1, &Options::body_level, {1, 2});
}

}  // namespace
}  // namespace hapticd::test

int main(int argc, char** argv) {
  using namespace hapticd::test;
  std::vector<ContactSession> sessions = contact_sessions();
  if (argc > 1 && std::strcmp(argv[1], "--quick") == 0) sessions.resize(1);
  std::vector<Judged> judged;
  for (ContactSession& session : sessions) judged.push_back(judge(std::move(session)));
  print_table(judged);
}
