// See daemon_options.h.
#include "server/daemon/daemon_options.h"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <set>
#include <sstream>

#include "device/attach/drivers.h"
#include "device/faulty/faulty_device.h"
#include "server/scene_io/choice_check.h"

namespace hapticd {
namespace {

/// Of the ids of tools (config.proto).
constexpr std::uint32_t kMaxToolId = 31;

/// Remembers the first error, with its place.
class FirstError : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int line, int column, const std::string& message) override {
    if (!text_.empty()) return;
    text_ = std::to_string(line + 1) + ":" + std::to_string(column + 1) + ": error: " + message;
  }
  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  std::string text_;
};

const std::map<std::string, v1::ClockMode> kClocks{{"realtime", v1::CLOCK_MODE_REALTIME},
                                                   {"virtual", v1::CLOCK_MODE_VIRTUAL}};
const std::map<std::string, v1::Pace> kPaces{{"timer", v1::PACE_TIMER},
                                             {"device", v1::PACE_DEVICE}};
const std::map<std::string, v1::RealtimePolicy> kPolicies{
    {"require", v1::REALTIME_POLICY_REQUIRE}, {"best_effort", v1::REALTIME_POLICY_BEST_EFFORT}};
const std::map<std::string, v1::Arm> kArms{{"off", v1::ARM_OFF},
                                           {"light", v1::ARM_LIGHT},
                                           {"firm", v1::ARM_FIRM},
                                           {"adversarial", v1::ARM_ADVERSARIAL}};

/// Names of the choices, for the help.
template <typename Choices>
std::string names_of(const Choices& choices) {
  std::string names;
  for (const auto& choice : choices) names += (names.empty() ? "" : "|") + choice.first;
  return names;
}

/// What --inject knows.
std::string kinds_of_fault() {
  std::string names;
  for (const InjectedKind& kind : kInjectedKinds) {
    names += (names.empty() ? "" : ", ") + std::string(kind.name);
  }
  return names;
}

/// How the sources of a driver look, for the help.
std::string form_of(const DriverEntry& driver) {
  const std::string kind(driver.kind);
  if (driver.argument == SourceArgument::kFile) return kind + ":FILE";
  return driver.argument == SourceArgument::kSerial ? kind + "[:SERIAL]" : kind;
}

/// All sources of devices, for the help.
std::string forms_of_sources() {
  std::string forms;
  for (const DriverEntry& driver : drivers()) forms += (forms.empty() ? "" : "|") + form_of(driver);
  return forms;
}

/// The same in a sentence, serials left out.
std::string sources_in_words() {
  std::string words;
  for (const DriverEntry& driver : drivers()) {
    const bool last = driver.kind == drivers().back().kind;
    words += words.empty() ? "" : last ? " or " : ", ";
    words += driver.kind;
    if (driver.argument == SourceArgument::kFile) words += ":FILE";
  }
  return words;
}

/// Adds --name VALUE for a Config field.
template <typename Value, typename Set>
void add(CLI::App& app, const std::string& name, const std::string& value_name,
         const std::string& help, Set set) {
  app.add_option_function<Value>(name, set, help)->type_name(value_name);
}

template <typename Enum, typename Set>
void add_choice(CLI::App& app, const std::string& name, const std::map<std::string, Enum>& choices,
                const std::string& help, Set set) {
  app.add_option_function<std::string>(
         name, [&choices, set](const std::string& text) { set(choices.at(text)); }, help)
      ->check(CLI::Validator(CLI::IsMember(choices)).description(""))
      ->type_name(names_of(choices));
}

[[noreturn]] void refuse(const std::string& text) { throw StartError(kExitUsage, text); }

void add_options(CLI::App& app, v1::Config& given, DaemonOptions& options) {
  add<std::string>(app, "--config", "FILE", "configuration in protobuf text format, same names",
                   [&](const std::string& v) { options.config_file = v; });
  add<std::string>(app, "--scene", "NAME|FILE", "scene to play (guqin)",
                   [&](const std::string& v) { given.set_scene(v); });
  add<std::string>(app, "--device", forms_of_sources(), "device of every tool (simulated)",
                   [&](const std::string& v) { given.add_device()->set_source(v); });
  add_choice(app, "--clock", kClocks, "what drives time (realtime)",
             [&](v1::ClockMode v) { given.set_clock(v); });
  add<double>(app, "--rate", "HZ", "ticks per second, 250 to 10000 (1000)",
              [&](double v) { given.set_rate(v); });
  add_choice(app, "--pace", kPaces,
             "what ticks wait for: the timer, or the reports of the first tool's device (timer)",
             [&](v1::Pace v) { given.set_pace(v); });
  add<std::string>(app, "--listen", "ADDR:PORT", "address and UDP port (127.0.0.1:47800)",
                   [&](const std::string& v) { given.set_listen(v); });
  add<std::string>(app, "--keys", "DIR",
                   "folder with view.key and control.key, made by 'hapticctl keygen' (none: "
                   "everyone on loopback)",
                   [&](const std::string& v) { given.set_keys(v); });
  app.add_flag_callback(
      "--verify", [&] { given.set_verify(true); },
      "compare a replay with its recording, bit for bit; ends with 5 when it differs, 8 when the "
      "recording is of other physics, so that only its poses are compared");
  add<std::string>(app, "--record", "FILE", "record the whole session to an MCAP file",
                   [&](const std::string& v) {
                     if (v.empty()) refuse("--record: the name is empty. Give a file.");
                     given.set_record(v);
                   });
  add<std::string>(app, "--quality", "0..4|auto", "quality of every scene (the scene's own)",
                   [&](const std::string& v) { given.set_quality(v); });
  add<double>(app, "--budget-us", "N",
              "CPU time that bounds the work of a tick, and that quality auto follows; 0: no bound "
              "(half the tick)",
              [&](double v) { given.set_budget_us(v); });
  add<std::string>(app, "--gesture", "NAME", "gesture of the simulated hands (demonstration)",
                   [&](const std::string& v) { given.set_gesture(v); });
  add_choice(app, "--arm", kArms, "arm behind each simulated hand (light)",
             [&](v1::Arm v) { given.set_arm(v); });
  add<std::uint64_t>(app, "--seed", "N", "seed of everything random (1)",
                     [&](std::uint64_t v) { given.set_seed(v); });
  add_choice(app, "--realtime", kPolicies, "what to do without realtime privileges (best_effort)",
             [&](v1::RealtimePolicy v) { given.set_realtime(v); });
  add<std::uint32_t>(app, "--cpu", "N", "processor of the haptic thread (any)",
                     [&](std::uint32_t v) { given.set_cpu(v); });
  add<double>(app, "--max-force", "N", "largest force, newtons (the device's own)",
              [&](double v) { given.set_max_force(v); });
  add<std::string>(
      app, "--inject", "WHAT:SEED",
      "put a fault before the device and arm every guard, to see what happens: " + kinds_of_fault(),
      [&](const std::string& v) { given.set_inject(v); });
  app.add_flag("--check", options.check_only, "check options, scene and gesture, play nothing");
}

void fill_defaults(v1::Config& config) {
  if (config.scene().empty()) config.set_scene("guqin");
  if (config.device_size() == 0) config.add_device();
  for (v1::DeviceChoice& device : *config.mutable_device()) {
    if (device.source().empty()) device.set_source("simulated");
    const std::optional<DeviceSource> source = parse_source(device.source());
    if (source && device.profile().empty()) {
      device.set_profile(std::string(source->driver->profile));
    }
  }
  if (config.clock() == v1::CLOCK_MODE_UNSPECIFIED) config.set_clock(v1::CLOCK_MODE_REALTIME);
  if (!config.has_rate()) config.set_rate(1000.0);
  if (config.pace() == v1::PACE_UNSPECIFIED) config.set_pace(v1::PACE_TIMER);
  if (config.listen().empty()) config.set_listen("127.0.0.1:47800");
  if (config.gesture().empty()) config.set_gesture("demonstration");
  if (config.arm() == v1::ARM_UNSPECIFIED) config.set_arm(v1::ARM_LIGHT);
  if (!config.has_seed()) config.set_seed(1);
  if (config.realtime() == v1::REALTIME_POLICY_UNSPECIFIED) {
    config.set_realtime(v1::REALTIME_POLICY_BEST_EFFORT);
  }
}

/// The name goes into messages, whose text is UTF-8, and onto terminals.
void check_record(const std::string& file) {
  const bool control = std::any_of(file.begin(), file.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
  if (control || !google::protobuf::internal::IsStructurallyValidUTF8(file)) {
    refuse("--record: the name is not plain UTF-8 text. Give another.");
  }
}

void check_devices(const v1::Config& config) {
  std::set<std::uint32_t> tools;
  for (const v1::DeviceChoice& device : config.device()) {
    if (device.tool_id() > kMaxToolId) {
      refuse("device: tool " + std::to_string(device.tool_id()) +
             " is not in [0, 31]. Give the tool_id of a tool of the scene.");
    }
    if (!tools.insert(device.tool_id()).second) {
      refuse("device: tool " + std::to_string(device.tool_id()) + " has two. Give each tool one.");
    }
    const std::optional<DeviceSource> source = parse_source(device.source());
    if (!source) {
      refuse("--device: '" + device.source() + "' is not known. Choose " + sources_in_words() +
             ".");
    }
    const bool replay = source->driver->driver == DeviceDriver::kReplay;
    if (source->driver->open != nullptr && config.clock() == v1::CLOCK_MODE_VIRTUAL) {
      refuse("--device: a real device needs the real clock. Leave --clock out.");
    }
    if (replay && (config.device_size() > 1 || !config.record().empty())) {
      refuse("--device: a replay plays alone: leave other devices and --record out.");
    }
    if (config.verify() && !replay) {
      refuse("--verify: there is nothing to compare. Give --device replay:FILE.");
    }
  }
}

void check_pace(const v1::Config& config) {
  if (config.pace() != v1::PACE_DEVICE) return;
  if (config.clock() == v1::CLOCK_MODE_VIRTUAL) {
    refuse("--pace device: virtual time waits for no device. Leave --clock or --pace out.");
  }
  const auto first =
      std::min_element(config.device().begin(), config.device().end(),
                       [](const auto& a, const auto& b) { return a.tool_id() < b.tool_id(); });
  if (parse_source(first->source())->driver->on_time) return;
  refuse("--pace device: '" + first->source() +
         "' of the first tool sends no report on time. Give it --device hid, or leave --pace out.");
}

}  // namespace

void read_config_file(const std::string& file, v1::Config& config) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw StartError(kExitInput, file + ": cannot be read. Name a readable file with --config.");
  }
  std::stringstream text;
  text << stream.rdbuf();
  google::protobuf::TextFormat::Parser parser;
  FirstError error;
  parser.RecordErrorsTo(&error);
  google::protobuf::TextFormat::ParseInfoTree places;
  parser.WriteLocationsTo(&places);
  if (!parser.ParseFromString(text.str(), &config)) {
    throw StartError(kExitInput, file + ":" + error.text() +
                                     ". Fields are those of the options, '-' written '_'.");
  }
  if (const std::optional<UnknownChoice> unknown = unknown_choice(config)) {
    const auto* field = v1::Config::descriptor()->FindFieldByName(unknown->path);
    const auto place = places.GetLocation(field, -1);
    throw StartError(kExitInput, file + ":" + std::to_string(place.line + 1) + ":" +
                                     std::to_string(place.column + 1) +
                                     ": error: " + unknown->path + ": " + unknown->message);
  }
}

void check_config(const v1::Config& config) {
  const auto in = [](double value, double low, double high) {
    return value >= low && value <= high;
  };
  if (!in(config.rate(), 250.0, 10000.0)) {
    refuse("--rate: not in [250, 10000]. Give ticks per second.");
  }
  if (config.has_max_force() && !in(config.max_force(), 0.0, 1000.0)) {
    refuse("--max-force: not in [0, 1000]. Give newtons.");
  }
  const std::string& quality = config.quality();
  if (!quality.empty() && quality != "auto" &&
      (quality.size() != 1 || quality < "0" || quality > "4")) {
    refuse("--quality: '" + quality + "' is not known. Give a level, 0 to 4, or auto.");
  }
  if (config.has_budget_us() && !in(config.budget_us(), 0.0, 1e6)) {
    refuse("--budget-us: not in [0, 1e6]. Give microseconds of CPU time per tick; 0: no bound.");
  }
  if (quality == "auto" && config.has_budget_us() && config.budget_us() == 0.0) {
    refuse("--budget-us: 0 leaves quality auto nothing to follow. Give microseconds, or a level.");
  }
  if (!config.inject().empty() && !parse_injection(config.inject())) {
    refuse("--inject: '" + config.inject() +
           "' is not known. Give WHAT:SEED, such as nan:7; WHAT is " + kinds_of_fault() + ".");
  }
  check_record(config.record());
  if (config.has_cpu() && config.cpu() > 1023) refuse("--cpu: not in [0, 1023].");
  check_devices(config);
  check_pace(config);
}

void settle_config(DaemonOptions& options) {
  v1::Config config;
  if (!options.config_file.empty()) read_config_file(options.config_file, config);
  if (options.given.device_size() > 0) config.clear_device();
  config.MergeFrom(options.given);
  options.gesture_given = !config.gesture().empty();
  fill_defaults(config);
  check_config(config);
  options.config = std::move(config);
}

bool read_options(int argc, const char* const* argv, DaemonOptions& options) {
  CLI::App app(
      "hapticd: a daemon for 6-DoF haptic rendering. Started with nothing, it plays the Guqin with "
      "a "
      "simulated device and a demonstration gesture, and serves clients on 127.0.0.1:47800.",
      "hapticd");
  app.set_version_flag("--version", "hapticd " HAPTICD_VERSION);
  app.footer(
      "hapticd doctor examines the machine: hapticd doctor --help. hapticd device list names\n"
      "the devices that are plugged in.\n"
      "Exit codes: 0 good, 1 bad scene, gesture, profile or configuration, 2 bad command line,\n"
      "3 address not available, 4 realtime required and refused, 5 a verified replay differs,\n"
      "7 the requested recording cannot be started.");
  add_options(app, options.given, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    app.exit(success);
    return false;
  } catch (const CLI::ParseError& error) {
    refuse(std::string(error.what()) + ". See hapticd --help.");
  }
  settle_config(options);
  return true;
}

}  // namespace hapticd
