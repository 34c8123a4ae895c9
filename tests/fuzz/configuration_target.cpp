// See configuration_target.h.
#include "tests/fuzz/configuration_target.h"

#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <stdexcept>
#include <string>

#include "server/daemon/daemon_options.h"
#include "tests/fuzz/plain_line.h"
#include "tests/fuzz/scratch_folder.h"

namespace hapticd::test {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);
}

/// False for NaN.
bool within(double value, double low, double high) { return value >= low && value <= high; }

/// A value of its enum, and not the first, which is none.
template <typename Enum>
bool is_chosen(Enum value, const google::protobuf::EnumDescriptor& type) {
  return value != 0 && type.FindValueByNumber(value) != nullptr;
}

void check_devices(const v1::Config& config) {
  require(config.device_size() >= 1 && config.device_size() <= 32, "no device, or too many");
  std::set<std::uint32_t> tools;
  for (const v1::DeviceChoice& device : config.device()) {
    require(device.tool_id() <= 31 && tools.insert(device.tool_id()).second, "two for a tool");
    const std::string kind = device.source().substr(0, device.source().find(':'));
    const std::set<std::string> kinds{"simulated", "scripted", "replay",
                                      "hid",       "pid",      "spacemouse"};
    require(kinds.count(kind) == 1, "a source that is none");
    require(kind != "replay" || (device.source().size() > 7 && config.device_size() == 1),
            "a replay of no file, or beside others");
  }
}

void check_taken(const v1::Config& config) {
  require(within(config.rate(), 250.0, 10000.0), "a rate out of range");
  require(!config.has_max_force() || within(config.max_force(), 0.0, 1000.0), "a force");
  require(!config.has_budget_us() || within(config.budget_us(), 0.0, 1e6), "a budget");
  require(!config.has_cpu() || config.cpu() <= 1023, "a processor that is none");
  require(is_chosen(config.clock(), *v1::ClockMode_descriptor()), "no clock");
  require(is_chosen(config.pace(), *v1::Pace_descriptor()), "no pace");
  require(is_chosen(config.arm(), *v1::Arm_descriptor()), "no arm");
  require(is_chosen(config.realtime(), *v1::RealtimePolicy_descriptor()), "no policy");
  const std::set<std::string> qualities{"", "0", "1", "2", "3", "4", "auto"};
  require(qualities.count(config.quality()) == 1, "a quality that is none");
  require(config.has_seed() && !config.scene().empty() && !config.gesture().empty() &&
              !config.listen().empty(),
          "a default is missing");
  for (const std::string* name : {&config.scene(), &config.gesture(), &config.record(),
                                  &config.keys(), &config.stop_key(), &config.stop_listen()}) {
    std::uint32_t character = 0;
    for (std::size_t at = 0; at < name->size();) {
      const std::size_t size = decode_character(*name, at, character);
      require(size > 0 && character >= 0x20 && character != 0x7f, "a name that is no text");
      at += size;
    }
  }
  check_devices(config);
}

/// `text` has the form FILE:LINE:COLUMN: or FILE: and names a line that there is.
void check_place(const std::string& text, const std::string& file, std::int64_t lines) {
  require(text.starts_with(file + ":"), "a refusal that does not name its file");
  const std::string rest = text.substr(file.size() + 1);
  if (rest.starts_with(" ")) return;
  const std::int64_t line = std::strtoll(rest.c_str(), nullptr, 10);
  require(line >= 1 && line <= lines, "a refusal that names no line of the file");
}

void check_refusal(const StartError& error, const std::string& file, std::int64_t lines) {
  const std::string text = error.what();
  require(is_plain_line(text), "a refusal that a terminal obeys");
  const bool ends = text.ends_with('.') || text.ends_with('?');
  require(ends && text.size() > 20, "a refusal that is no sentence");
  if (error.exit_code() == kExitInput) {
    check_place(text, file, lines);
  } else {
    require(error.exit_code() == kExitUsage, "an exit code of something else");
    require(text.starts_with("--") || text.starts_with("device:"), "a refusal of no option");
  }
}

}  // namespace

bool check_configuration_bytes(std::span<const std::uint8_t> bytes) {
  static const ScratchFolder folder;
  const std::string file = folder.write("hapticd.textproto", bytes);
  const google::protobuf::LogSilencer silence;
  DaemonOptions options;
  options.config_file = file;
  try {
    settle_config(options);
  } catch (const StartError& error) {
    const auto lines = 1 + std::count(bytes.begin(), bytes.end(), std::uint8_t{'\n'});
    check_refusal(error, file, lines);
    return false;
  }
  check_taken(options.config);
  return true;
}

}  // namespace hapticd::test
