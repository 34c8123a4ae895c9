// See recording_table.h.
#include "proto/recording/recording_table.h"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <fstream>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "proto/recording/recording_reader.h"

namespace hapticd {
namespace {

/// What stands in the columns of a tool that the scene of the tick does not have.
constexpr const char* kNoTool =
    "inputs { pose_wh { p_m: [0, 0, 0] q: [1, 0, 0, 0] } stiffness_scale: 1"
    " twist_wh_w { v_m_per_s: [0, 0, 0] w_rad_per_s: [0, 0, 0] } }"
    "outputs { pose_wg { p_m: [0, 0, 0] q: [1, 0, 0, 0] }"
    " wrench_h_w { f_n: [0, 0, 0] t_n_m: [0, 0, 0] }"
    " wrench_unlimited_h_w { f_n: [0, 0, 0] t_n_m: [0, 0, 0] } }";

struct Column {
  std::string name;
  std::variant<std::int64_t, double> value;
};
using Row = std::vector<Column>;

/// A message lacks numbers that it has to have.
struct Damaged {};

class RowMaker {
 public:
  explicit RowMaker(Row& row) : row_(row) { row_.clear(); }
  template <typename Whole>
  void whole(const std::string& name, Whole value) {
    row_.push_back({name, static_cast<std::int64_t>(value)});
  }
  void real(const std::string& name, double value) { row_.push_back({name, value}); }
  /// One column for each letter of `axes`.
  void reals(const std::string& name, std::string_view axes, const char* unit,
             const google::protobuf::RepeatedField<double>& values) {
    if (static_cast<std::size_t>(values.size()) != axes.size()) throw Damaged{};
    for (int k = 0; k < values.size(); ++k) {
      real(name + axes[static_cast<std::size_t>(k)] + unit, values[k]);
    }
  }

 private:
  Row& row_;
};

void add_tool(const v1::ToolInput& input, const v1::ToolOutput& output, const std::string& of,
              RowMaker& row) {
  row.whole(of + "id", input.tool_id());
  row.reals(of + "wh_", "xyz", "_m", input.pose_wh().p_m());
  row.reals(of + "wh_q_", "wxyz", "", input.pose_wh().q());
  row.reals(of + "wh_v_", "xyz", "_m_per_s", input.twist_wh_w().v_m_per_s());
  row.reals(of + "wh_w_", "xyz", "_rad_per_s", input.twist_wh_w().w_rad_per_s());
  row.reals(of + "wg_", "xyz", "_m", output.pose_wg().p_m());
  row.reals(of + "wg_q_", "wxyz", "", output.pose_wg().q());
  row.reals(of + "f", "xyz", "_n", output.wrench_h_w().f_n());
  row.reals(of + "t", "xyz", "_n_m", output.wrench_h_w().t_n_m());
  row.reals(of + "f_unlimited_", "xyz", "_n", output.wrench_unlimited_h_w().f_n());
  row.reals(of + "t_unlimited_", "xyz", "_n_m", output.wrench_unlimited_h_w().t_n_m());
  if (input.stiffness_scale_size() != 1) throw Damaged{};
  row.real(of + "stiffness_scale", input.stiffness_scale(0));
  row.whole(of + "age_ns", input.age_ns());
  row.whole(of + "buttons", input.buttons());
  std::uint64_t flags = 0;
  for (const int flag : output.flags()) {
    if (flag < 1 || flag > 16) throw Damaged{};
    flags |= std::uint64_t{1} << (flag - 1);
  }
  row.whole(of + "flags", flags);
}

void tick_row(const v1::TickRecord& tick, int tools, Row& columns) {
  static const v1::TickRecord none = [] {
    v1::TickRecord record;
    google::protobuf::TextFormat::ParseFromString(kNoTool, &record);
    return record;
  }();
  RowMaker row(columns);
  row.whole("scene_id", tick.scene_id());
  row.whole("tick", tick.tick());
  row.whole("t_ns", tick.t_ns());
  row.whole("dt_ns", tick.dt_ns());
  row.whole("loop_state", tick.loop_state());
  row.whole("cause", tick.cause());
  row.whole("skipped_ticks", tick.skipped());
  row.whole("level", tick.budget().level());
  row.whole("substeps", tick.budget().substeps());
  row.whole("qp_iterations", tick.budget().qp_iterations());
  row.whole("sphere_tests", tick.budget().sphere_tests());
  row.whole("cpu_ns", tick.cpu_ns());
  if (tick.outputs_size() != tick.inputs_size()) throw Damaged{};
  for (int k = 0; k < tools; ++k) {
    const bool there = k < tick.inputs_size();
    add_tool(there ? tick.inputs(k) : none.inputs(0), there ? tick.outputs(k) : none.outputs(0),
             "tool" + std::to_string(k) + "_", row);
  }
}

void event_row(const v1::EventRecord& event, Row& columns) {
  const v1::Tone& tone = event.item().tone();
  const v1::Contact& contact = event.item().contact();
  const v1::StringRadius& radius = event.item().string_radius();
  const v1::Fault& fault = event.item().fault();
  const v1::StringSounding& sounding = event.item().string_sounding();
  const int kind = event.item().has_tone()            ? 1
                   : event.item().has_contact()       ? 2
                   : event.item().has_string_radius() ? 3
                   : event.item().has_fault()         ? 4
                                                      : 5;
  RowMaker row(columns);
  row.whole("tick", event.tick());
  row.whole("kind", kind);
  row.whole("t_ns", tone.t_ns() + contact.t_ns() + radius.t_ns() + fault.t_ns() + sounding.t_ns());
  row.whole("tool_id", tone.tool_id() + contact.tool_id() + fault.tool_id() + sounding.tool_id());
  row.whole("string_index", tone.string_index() + contact.string_index() + radius.string_index() +
                                sounding.string_index());
  row.whole("phase", int{contact.phase()} + radius.phase());
  row.whole("cause", fault.cause());
  row.whole("latched", fault.latched());
  row.real("frequency_hz", double{tone.frequency_hz()} + double{radius.frequency_hz()} +
                               double{sounding.frequency_hz()});
  row.real("amplitude_m", double{tone.amplitude_m()});
  row.real("level", double{tone.level()});
  row.real("lambda",
           double{tone.lambda()} + double{contact.lambda()} + double{sounding.lambda_from()});
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
    for (Row row; next(row); ++count_) tools_ = std::max(tools_, tick_.inputs_size());
    reader_.rewind();
  }
  bool next(Row& row) {
    RecordedMessage message;
    while (reader_.next(message)) {
      if (message.kind != (ticks_ ? RecordKind::kTick : RecordKind::kEvent)) continue;
      google::protobuf::Message& parsed =
          ticks_ ? static_cast<google::protobuf::Message&>(tick_) : event_;
      try {
        if (!parsed.ParseFromArray(message.data.data(), static_cast<int>(message.data.size()))) {
          throw Damaged{};
        }
        if (ticks_) {
          tick_row(tick_, tools_, row);
        } else {
          event_row(event_, row);
        }
        return true;
      } catch (const Damaged&) {
        throw RecordingError(reader_.path() + (ticks_ ? ": a tick" : ": an event") +
                             " is damaged. Export another recording.");
      }
    }
    return false;
  }
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

 private:
  RecordingReader reader_;
  bool ticks_;
  std::uint64_t count_ = 0;
  int tools_ = 1;
  v1::TickRecord tick_;
  v1::EventRecord event_;
};

char* written(std::int64_t whole, char* begin, char* end) {
  return std::to_chars(begin, end, whole).ptr;
}
char* written(double real, char* begin, char* end) {
  return std::to_chars(begin, end, real, std::chars_format::general, 17).ptr;
}

void write_csv(Rows& rows, std::ostream& out) {
  Row row;
  bool named = false;
  while (rows.next(row)) {
    for (std::size_t k = 0; !named && k < row.size(); ++k) out << (k > 0 ? "," : "") << row[k].name;
    if (!std::exchange(named, true)) out << '\n';
    const char* comma = "";
    for (const Column& column : row) {
      std::array<char, 40> text{};
      // With a point in every locale.
      const char* const end = std::visit(
          [&](auto number) { return written(number, text.data(), text.data() + text.size()); },
          column.value);
      out << std::exchange(comma, ",") << std::string_view(text.data(), end);
    }
    out << '\n';
  }
}

void write_bytes(std::uint64_t number, std::size_t bytes, std::ostream& out) {
  for (std::size_t k = 0; k < bytes; ++k) out.put(static_cast<char>(number >> (8 * k) & 0xFFU));
}

void write_npy_header(const Row& row, std::uint64_t count, std::ostream& out) {
  std::string header = "{'descr': [";
  for (const Column& column : row) {
    header += "('" + column.name + "', '" +
              (std::holds_alternative<double>(column.value) ? "<f8" : "<i8") + "'), ";
  }
  header += "], 'fortran_order': False, 'shape': (" + std::to_string(count) + ",), }";
  constexpr std::size_t kPrefix = 12;
  constexpr std::size_t kAlignment = 64;
  header.append(kAlignment - 1 - (kPrefix + header.size()) % kAlignment, ' ');
  header += '\n';
  out.write("\x93NUMPY\x02\x00", 8);
  write_bytes(header.size(), 4, out);
  out << header;
}

void write_npy(Rows& rows, std::ostream& out) {
  Row row;
  bool named = false;
  while (rows.next(row)) {
    if (!std::exchange(named, true)) write_npy_header(row, rows.count(), out);
    for (const Column& column : row) {
      const auto* whole = std::get_if<std::int64_t>(&column.value);
      write_bytes(whole != nullptr ? static_cast<std::uint64_t>(*whole)
                                   : std::bit_cast<std::uint64_t>(std::get<double>(column.value)),
                  8, out);
    }
  }
}

}  // namespace

std::uint64_t write_table(const std::string& path, TableRows rows, TableForm form,
                          const std::string& file) {
  const bool ticks = rows == TableRows::kTicks;
  Rows read(path, ticks);
  if (read.count() == 0) {
    throw RecordingError(path + ": there are no " + (ticks ? "ticks" : "events") +
                         " in it. Nothing was written.");
  }
  std::ofstream out(file, std::ios::binary);
  if (form == TableForm::kCsv) {
    write_csv(read, out);
  } else {
    write_npy(read, out);
  }
  out.flush();
  if (!out) throw RecordingError(file + ": cannot be written. Name another file.");
  return read.count();
}

}  // namespace hapticd
