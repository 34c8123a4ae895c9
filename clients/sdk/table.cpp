// See hapticd/client/table.h.
#include <hapticd/client/table.h>

#include <array>
#include <charconv>
#include <fstream>
#include <stdexcept>

#include "proto/recording/recording_table.h"

namespace hapticd::client {
namespace {

/// Columns of a tool, in the order in which add_tool() writes them.
constexpr std::array<const char*, 22> kToolColumns{
    "id",     "wh_x_m", "wh_y_m", "wh_z_m", "wh_q_w", "wh_q_x",       "wh_q_y", "wh_q_z",
    "wg_x_m", "wg_y_m", "wg_z_m", "wg_q_w", "wg_q_x", "wg_q_y",       "wg_q_z", "fx_n",
    "fy_n",   "fz_n",   "tx_n_m", "ty_n_m", "tz_n_m", "minimum_gap_m"};

/// With a point in every locale.
std::string text_of(double number) {
  std::array<char, 40> text{};
  char* const end =
      std::to_chars(text.data(), text.data() + text.size(), number, std::chars_format::general, 17)
          .ptr;
  return {text.data(), end};
}

/// As many columns as their names; numbers that are missing stay empty.
template <typename Numbers>
void add(const Numbers& numbers, int count, std::string& row) {
  for (int k = 0; k < count; ++k) {
    row += ',';
    if (k < numbers.size()) row += text_of(static_cast<double>(numbers[k]));
  }
}

void add_tool(const v1::ToolState& tool, std::string& row) {
  row += ',' + std::to_string(tool.tool_id());
  add(tool.p_wh_m(), 3, row);
  add(tool.q_wh(), 4, row);
  add(tool.p_wg_m(), 3, row);
  add(tool.q_wg(), 4, row);
  add(tool.wrench_h_w(), 6, row);
  row += ',' + text_of(static_cast<double>(tool.minimum_gap_m()));
}

std::string header(int tools) {
  std::string row = "tick,t_ns,loop_state,cause";
  for (int k = 0; k < tools; ++k) {
    for (const char* name : kToolColumns) row += ",tool" + std::to_string(k) + "_" + name;
  }
  return row + "\n";
}

std::string row_of(const v1::State& state, int tools) {
  std::string row = std::to_string(state.tick()) + ',' + std::to_string(state.t_ns()) + ',' +
                    std::to_string(int{state.loop_state()}) + ',' +
                    std::to_string(int{state.cause()});
  for (int k = 0; k < tools; ++k) {
    if (k < state.tools_size()) {
      add_tool(state.tools(k), row);
    } else {
      row.append(kToolColumns.size(), ',');
    }
  }
  return row + "\n";
}

}  // namespace

inline namespace abi_0 {

void write_states(const std::vector<v1::State>& states, const std::string& file) {
  if (states.empty()) throw std::runtime_error(file + ": there is no State to be written");
  const int tools = states.front().tools_size();
  std::ofstream out(file, std::ios::binary);
  out << header(tools);
  for (const v1::State& state : states) out << row_of(state, tools);
  out.flush();
  if (!out) throw std::runtime_error(file + ": cannot be written. Name another file.");
}

std::uint64_t write_recording(const std::string& recording, RecordedRows rows,
                              const std::string& file) {
  const bool npy = file.size() > 4 && file.compare(file.size() - 4, 4, ".npy") == 0;
  return write_table(recording,
                     rows == RecordedRows::kTicks ? TableRows::kTicks : TableRows::kEvents,
                     npy ? TableForm::kNpy : TableForm::kCsv, file);
}

}  // namespace abi_0
}  // namespace hapticd::client
