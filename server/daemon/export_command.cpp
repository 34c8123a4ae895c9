// See export_command.h. Columns have their unit at the end of their name; whole numbers stay whole,
// real ones keep every bit (17 digits in CSV). A table is read twice: how many tools it needs is
// known at its end.
#include "server/daemon/export_command.h"

#include <CLI/CLI.hpp>
#include <bit>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "proto/recording/recording_reader.h"
#include "server/daemon/daemon_options.h"
#include "server/recorder/tick_record.h"

namespace hapticd {
namespace {

/// A field of a row.
using Value = std::variant<std::int64_t, double>;

struct Column {
  std::string name;
  Value value;
};
using Row = std::vector<Column>;

class RowMaker {
 public:
  explicit RowMaker(Row& row) : row_(row) { row_.clear(); }
  void whole(const std::string& name, std::int64_t value) { row_.push_back({name, value}); }
  void whole(const std::string& name, std::uint64_t value) {
    row_.push_back({name, static_cast<std::int64_t>(value)});
  }
  void real(const std::string& name, double value) { row_.push_back({name, value}); }
  template <std::size_t N>
  void reals(const std::string& name, const char (&axes)[N], const char* unit,
             const std::array<double, N - 1>& values) {
    for (std::size_t k = 0; k + 1 < N; ++k) real(name + axes[k] + unit, values[k]);
  }

 private:
  Row& row_;
};

void add_tool(const ToolTick& tool, std::int64_t t_ns, std::size_t k, RowMaker& row) {
  const std::string of = "tool" + std::to_string(k) + "_";
  row.whole(of + "id", std::int64_t{tool.tool_id});
  row.reals(of + "wh_", "xyz", "_m", tool.X_WH.p);
  row.reals(of + "wh_q_", "wxyz", "", tool.X_WH.q);
  row.reals(of + "wh_v_", "xyz", "_m_per_s", tool.V_WH.v);
  row.reals(of + "wh_w_", "xyz", "_rad_per_s", tool.V_WH.w);
  row.reals(of + "wg_", "xyz", "_m", tool.X_WG.p);
  row.reals(of + "wg_q_", "wxyz", "", tool.X_WG.q);
  row.reals(of + "f", "xyz", "_n", tool.F_written_H_W.f);
  row.reals(of + "t", "xyz", "_n_m", tool.F_written_H_W.t);
  row.reals(of + "f_unlimited_", "xyz", "_n", tool.F_computed_H_W.f);
  row.reals(of + "t_unlimited_", "xyz", "_n_m", tool.F_computed_H_W.t);
  row.real(of + "stiffness_scale", tool.stiffness.scale);
  row.whole(of + "age_ns", std::max<std::int64_t>(t_ns - tool.sample.t_ns, 0));
  row.whole(of + "buttons", std::int64_t{tool.sample.buttons});
  row.whole(of + "flags", std::int64_t{tool.flags});
}

void tick_row(const Tick& tick, std::size_t tools, Row& columns) {
  RowMaker row(columns);
  row.whole("scene_id", std::int64_t{tick.scene_id});
  row.whole("tick", tick.tick);
  row.whole("t_ns", tick.t_ns);
  row.whole("dt_ns", tick.dt_ns);
  row.whole("loop_state", std::int64_t{static_cast<int>(tick.state)});
  row.whole("cause", std::int64_t{static_cast<int>(tick.cause)});
  row.whole("skipped_ticks", tick.skipped);
  row.whole("level", std::int64_t{tick.budget.level});
  row.whole("substeps", std::int64_t{tick.work.sub_steps});
  row.whole("qp_iterations", std::int64_t{tick.work.qp_iterations});
  row.whole("sphere_tests", tick.work.sphere_tests);
  row.whole("cpu_ns", std::int64_t{tick.times.cpu_ns});
  for (std::size_t k = 0; k < tools; ++k) {
    add_tool(k < tick.tools.size() ? tick.tools[k] : ToolTick{}, tick.t_ns, k, row);
  }
}

void event_row(const v1::EventRecord& event, Row& columns) {
  const v1::Tone& tone = event.item().tone();
  const v1::Contact& contact = event.item().contact();
  const v1::StringRadius& radius = event.item().string_radius();
  const v1::Fault& fault = event.item().fault();
  const int kind = event.item().has_tone()            ? 1
                   : event.item().has_contact()       ? 2
                   : event.item().has_string_radius() ? 3
                                                      : 4;
  RowMaker row(columns);
  row.whole("tick", event.tick());
  row.whole("kind", std::int64_t{kind});
  row.whole("t_ns", tone.t_ns() + contact.t_ns() + radius.t_ns() + fault.t_ns());
  row.whole("tool_id", std::int64_t{tone.tool_id()} + contact.tool_id() + fault.tool_id());
  row.whole("string_index",
            std::int64_t{tone.string_index()} + contact.string_index() + radius.string_index());
  row.whole("phase", std::int64_t{contact.phase()} + radius.phase());
  row.whole("cause", std::int64_t{fault.cause()});
  row.whole("latched", std::int64_t{fault.latched() ? 1 : 0});
  row.real("frequency_hz", double{tone.frequency_hz()} + double{radius.frequency_hz()});
  row.real("amplitude_m", double{tone.amplitude_m()});
  row.real("level", double{tone.level()});
  row.real("lambda", double{tone.lambda()} + double{contact.lambda()});
  row.real("decay_s", double{tone.decay_s()} + double{radius.decay_s()});
  row.real("normal_speed_m_per_s",
           double{tone.normal_speed_m_per_s()} + double{contact.normal_speed_m_per_s()});
  row.real("tangential_speed_m_per_s",
           double{tone.tangential_speed_m_per_s()} + double{contact.tangential_speed_m_per_s()});
  row.real("force_n", double{contact.force_n()});
  row.real("delta_m", double{radius.delta_m()});
  row.real("r_max_m", double{radius.r_max_m()});
}

/// The rows of a recording, one after the other.
class Rows {
 public:
  Rows(const std::string& path, bool ticks) : reader_(path), ticks_(ticks) {
    Row row;
    while (next(row, kMaxTools)) {
      ++count_;
      if (ticks_) tools_ = std::max(tools_, tick_->tools.size());
    }
    reader_.rewind();
  }
  bool next(Row& row) { return next(row, tools_); }
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

 private:
  bool next(Row& row, std::size_t tools) {
    RecordedMessage message;
    while (reader_.next(message)) {
      const auto size = static_cast<int>(message.data.size());
      if (ticks_ && message.kind == RecordKind::kTick) {
        v1::TickRecord record;
        if (!record.ParseFromArray(message.data.data(), size) || !to_tick(record, *tick_)) {
          throw RecordingError(reader_.path() + ": a tick is damaged. Export another recording.");
        }
        tick_row(*tick_, tools, row);
        return true;
      }
      v1::EventRecord event;
      if (ticks_ || message.kind != RecordKind::kEvent) continue;
      if (!event.ParseFromArray(message.data.data(), size)) {
        throw RecordingError(reader_.path() + ": an event is damaged. Export another recording.");
      }
      event_row(event, row);
      return true;
    }
    return false;
  }

  RecordingReader reader_;
  bool ticks_;
  std::uint64_t count_ = 0;
  std::size_t tools_ = 1;
  std::unique_ptr<Tick> tick_ = std::make_unique<Tick>();
};

void write_csv(Rows& rows, std::ostream& out) {
  Row row;
  bool named = false;
  while (rows.next(row)) {
    const char* comma = "";
    for (const Column& column : row) {
      if (named) break;
      out << comma << column.name;
      comma = ",";
    }
    if (!named) out << '\n';
    named = true;
    comma = "";
    for (const Column& column : row) {
      std::array<char, 40> text{};
      if (const auto* whole = std::get_if<std::int64_t>(&column.value)) {
        std::snprintf(text.data(), text.size(), "%lld", static_cast<long long>(*whole));
      } else {
        std::snprintf(text.data(), text.size(), "%.17g", std::get<double>(column.value));
      }
      out << comma << text.data();
      comma = ",";
    }
    out << '\n';
  }
}

void write_bytes(std::uint64_t number, std::size_t bytes, std::ostream& out) {
  for (std::size_t k = 0; k < bytes; ++k) out.put(static_cast<char>(number >> (8 * k) & 0xFFU));
}

/// Layout: numpy.lib.format, version 2.0; a structured array, little endian.
void write_npy(Rows& rows, std::ostream& out) {
  Row row;
  bool named = false;
  while (rows.next(row)) {
    if (!named) {
      std::string header = "{'descr': [";
      for (const Column& column : row) {
        header += "('" + column.name + "', '" +
                  (std::holds_alternative<double>(column.value) ? "<f8" : "<i8") + "'), ";
      }
      header += "], 'fortran_order': False, 'shape': (" + std::to_string(rows.count()) + ",), }";
      constexpr std::size_t kPrefix = 12;
      constexpr std::size_t kAlignment = 64;
      header.append(kAlignment - 1 - (kPrefix + header.size()) % kAlignment, ' ');
      header += '\n';
      out.write("\x93NUMPY\x02\x00", 8);
      write_bytes(header.size(), 4, out);
      out << header;
      named = true;
    }
    for (const Column& column : row) {
      const auto* whole = std::get_if<std::int64_t>(&column.value);
      write_bytes(whole != nullptr ? static_cast<std::uint64_t>(*whole)
                                   : std::bit_cast<std::uint64_t>(std::get<double>(column.value)),
                  8, out);
    }
  }
}

void export_table(const std::string& recording, const std::string& what, const std::string& csv,
                  const std::string& npy) {
  Rows rows(recording, what == "ticks");
  if (rows.count() == 0) {
    throw RecordingError(recording + ": there are no " + what + " in it. Nothing was written.");
  }
  const std::string& path = csv.empty() ? npy : csv;
  std::ofstream out(path, std::ios::binary);
  if (csv.empty()) {
    write_npy(rows, out);
  } else {
    write_csv(rows, out);
  }
  out.flush();
  if (!out) throw RecordingError(path + ": cannot be written. Name another file.");
  std::printf("%llu %s in %s\n", static_cast<unsigned long long>(rows.count()), what.c_str(),
              path.c_str());
}

}  // namespace

int run_export(int argc, const char* const* argv) {
  std::string recording;
  std::string what = "ticks";
  std::string csv;
  std::string npy;
  CLI::App app("Writes a recording as a table, one row per tick or per event.", "hapticd export");
  app.add_option("FILE", recording, "recording")->required();
  app.add_option("--what", what, "ticks or events (ticks)")
      ->check(CLI::IsMember({"ticks", "events"}))
      ->type_name("ticks|events");
  auto* group = app.add_option_group("output");
  group->add_option("--csv", csv, "file to write, as text")->type_name("OUT");
  group->add_option("--npy", npy, "file to write, for numpy.load")->type_name("OUT");
  group->require_option(1);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitGood : kExitUsage;
  }
  try {
    export_table(recording, what, csv, npy);
  } catch (const RecordingError& error) {
    std::fprintf(stderr, "hapticd: %s\n", error.what());
    return kExitInput;
  }
  return kExitGood;
}

}  // namespace hapticd
