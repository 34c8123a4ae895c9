// See daemon_options.h.
#include "server/daemon/daemon_options.h"

#include <google/protobuf/stubs/common.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <type_traits>

#include "device/attach/drivers.h"
#include "device/faulty/faulty_device.h"
#include "proto/hints/command_line_fault.h"
#include "proto/hints/nearest_name.h"
#include "proto/hints/quantity.h"
#include "proto/hints/whole_number_option.h"
#include "proto/wire/choice_check.h"
#include "proto/wire/shown_text.h"
#include "server/confinement/confinement.h"
#include "server/scene_io/message_text.h"

namespace hapticd {
namespace {

namespace pb = google::protobuf;

/// First words that main() obeys before there are options.
const std::array<std::string, 3> kCommandNames{"doctor", "device", "export"};

/// Of the ids of tools (config.proto).
constexpr std::uint32_t kMaxToolId = 31;
/// Of the numbers of processors, as the kernel may have them.
constexpr std::uint32_t kMaxCpu = 1023;

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

/// The source that is meant by one that is not known.
std::string meant_source(const std::string& given) {
  std::vector<std::string> kinds;
  for (const DriverEntry& driver : drivers()) kinds.emplace_back(driver.kind);
  const std::string kind = hints::nearest_name(given.substr(0, given.find(':')), kinds);
  if (kind.empty()) return {};
  const auto driver = std::find_if(drivers().begin(), drivers().end(),
                                   [&kind](const DriverEntry& each) { return each.kind == kind; });
  return " Did you mean " + kind +
         (driver->argument == SourceArgument::kFile ? ":FILE" : std::string()) + "?";
}

/// `text` may quote what was given.
[[noreturn]] void refuse(const std::string& text) {
  throw StartError(kExitUsage, wire::shown_lines(text));
}

/// Refuses `given` where it is of a driver that plays a file, and names none.
void check_file_of_source(const std::string& given) {
  const std::string kind = given.substr(0, given.find(':'));
  const bool names_none = given.size() <= kind.size() + 1;
  for (const DriverEntry& driver : drivers()) {
    if (driver.argument != SourceArgument::kFile || driver.kind != kind || !names_none) continue;
    refuse("--device: the name of the file is missing after '" + given + "'. Give " + kind +
           ":FILE.");
  }
}

/// An option that is a field of Config, named like it with '-' for '_'.
struct FieldOption {
  const char* name;
  const char* value;  ///< what is to be given; of an enum: null, since its choices say it
  const char* help;
  const char* unit = "";  ///< of a real number
};

constexpr FieldOption kFieldOptions[] = {
    {"--scene", "NAME|FILE", "scene to play (guqin)"},
    {"--clock", nullptr, "what drives time (realtime)"},
    {"--rate", "HZ", "ticks per second, 250 to 10000 (1000)", "Hz"},
    {"--pace", nullptr,
     "what ticks wait for: the timer, or the reports of the first tool's device (timer)"},
    {"--listen", "ADDR:PORT", "address and UDP port (127.0.0.1:47800)"},
    {"--keys", "DIR",
     "folder with server.key, view.key, control.key and stop.key, made by 'hapticctl keygen' "
     "(none: everyone "
     "on "
     "loopback)"},
    {"--stop-listen", "ADDR:PORT|off",
     "address and UDP port of the Stop road (47801 at the address of --listen; another port if "
     "that "
     "is taken)"},
    {"--stop-key", "FILE", "key of the Stop road (stop.key in the folder of --keys)"},
    {"--record", "FILE", "record the whole session to an MCAP file"},
    {"--quality", "0..4|auto", "quality of every scene (the scene's own)"},
    {"--budget-us", "N",
     "CPU time that bounds the work of a tick, and that quality auto follows; 0: no bound (half "
     "the tick)",
     "us"},
    {"--gesture", "NAME", "gesture of the simulated hands (demonstration)"},
    {"--arm", nullptr, "arm behind each simulated hand (light)"},
    {"--seed", "N", "seed of everything random (1)"},
    {"--realtime", nullptr, "what to do without realtime privileges (best_effort)"},
    {"--cpu", "N", "processor of the haptic thread (any)"},
    {"--max-force", "N", "largest force, newtons (the device's own)", "N"},
};

/// Numbers of the enum's values by what options call them: CLOCK_MODE_VIRTUAL is virtual.
std::map<std::string, int> choices_of(const pb::EnumDescriptor& type) {
  std::map<std::string, int> choices;
  const std::size_t prefix = type.value(0)->name().size() - std::string_view("UNSPECIFIED").size();
  for (int i = 1; i < type.value_count(); ++i) {
    std::string name = type.value(i)->name().substr(prefix);
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    choices[name] = type.value(i)->number();
  }
  return choices;
}

double number_of(const FieldOption& option, const std::string& text) {
  const hints::Quantity quantity = hints::parse_quantity(text, option.unit);
  if (!quantity.fault.empty()) {
    refuse(std::string(option.name) + ": '" + text + "' cannot be read. " + quantity.fault);
  }
  return quantity.value;
}

/// Adds the option, which sets its field of `given`.
void add_option(CLI::App& app, const FieldOption& option, v1::Config& given) {
  std::string name(option.name + 2);
  std::replace(name.begin(), name.end(), '-', '_');
  const pb::FieldDescriptor* field = v1::Config::descriptor()->FindFieldByName(name);
  const pb::Reflection* r = given.GetReflection();
  const auto add = [&](const auto& kind, const auto& set) {
    using Value = std::decay_t<decltype(kind)>;
    return app.add_option_function<Value>(
        option.name, [=, &given](const Value& v) { set(r, &given, field, v); }, option.help);
  };
  switch (field->cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
      add(std::string(), [option](auto* of, auto* config, auto* which, const std::string& v) {
        of->SetDouble(config, which, number_of(option, v));
      })->type_name(option.value);
      break;
    case pb::FieldDescriptor::CPPTYPE_UINT32:  // cpu alone
      hints::takes_whole_number(add(std::uint32_t{}, std::mem_fn(&pb::Reflection::SetUInt32)), 0,
                                kMaxCpu)
          ->type_name(option.value);
      break;
    case pb::FieldDescriptor::CPPTYPE_UINT64:
      hints::takes_whole_number(add(std::uint64_t{}, std::mem_fn(&pb::Reflection::SetUInt64)), 0,
                                std::numeric_limits<std::uint64_t>::max())
          ->type_name(option.value);
      break;
    case pb::FieldDescriptor::CPPTYPE_ENUM: {
      const std::map<std::string, int> choices = choices_of(*field->enum_type());
      std::string names;
      for (const auto& choice : choices) names += (names.empty() ? "" : "|") + choice.first;
      add(std::string(),
          [choices](auto* of, auto* config, auto* which, const std::string& v) {
            of->SetEnumValue(config, which, choices.at(v));
          })
          ->check(CLI::Validator(CLI::IsMember(choices)).description(""))
          ->type_name(names);
      break;
    }
    default:
      add(std::string(), std::mem_fn(&pb::Reflection::SetString))->type_name(option.value);
      break;
  }
}

void add_options(CLI::App& app, DaemonOptions& options) {
  v1::Config& given = options.given;
  app.add_option("--config", options.config_file,
                 "configuration in protobuf text format, same names")
      ->type_name("FILE");
  for (const FieldOption& option : kFieldOptions) add_option(app, option, given);
  app.add_option_function<std::string>(
         "--device", [&given](const std::string& v) { given.add_device()->set_source(v); },
         "device of every tool (simulated)")
      ->type_name(forms_of_sources());
  app.add_flag_callback(
      "--verify", [&given] { given.set_verify(true); },
      "compare a replay with its recording, bit for bit; ends with 5 when it differs, 8 when the "
      "recording is of other physics, so that only its poses are compared");
  app.add_option_function<std::string>(
         "--inject", [&given](const std::string& v) { given.set_inject(v); },
         "put a fault before the device and arm every guard, to see what happens: " +
             kinds_of_fault() + "; SEED says when (1)")
      ->type_name("WHAT[:SEED]");
  app.add_flag(
      "--announce", options.announce,
      "announce this hapticd to the local network by mDNS, for hapticctl --discover; needs "
      "--keys, --listen 0.0.0.0:PORT or [::]:PORT, and avahi-daemon");
  app.add_flag(
      "--old-handshake", options.old_handshake,
      "serve clients and key files of 0.1 too, to which whoever has view.key could pose as "
      "this hapticd; the next version is without it");
  const std::map<std::string, Confinement> confinements{
      {"off", Confinement::kOff}, {"on", Confinement::kOn}, {"strict", Confinement::kStrict}};
  app.add_option_function<std::string>(
         "--confine",
         [confinements](const std::string& v) { choose_confinement(confinements.at(v)); },
         "what becomes of system calls that a thread's role has no use for: off, they are made; "
         "on, they fail, and files that nothing names are out of reach; strict, such a call ends "
         "hapticd, for tests (on)")
      ->check(CLI::Validator(CLI::IsMember(confinements)).description(""))
      ->type_name("off|on|strict");
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

/// Names go into messages, whose text is UTF-8, and onto terminals.
void check_name(const std::string& option, const std::string& name) {
  const bool control = std::any_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
  if (control || !pb::internal::IsStructurallyValidUTF8(name)) {
    refuse(option + ": the name is not plain UTF-8 text. Give another.");
  }
  // A shell replaces it at the beginning of a word alone, and not within quotes.
  if (name.starts_with("~/")) {
    refuse(option + ": the ~ of '" + name + "' was not replaced. Give the whole path.");
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
    check_file_of_source(device.source());
    const std::optional<DeviceSource> source = parse_source(device.source());
    if (!source) {
      refuse("--device: '" + device.source() + "' is not known." + meant_source(device.source()) +
             " Choose " + sources_in_words() + ".");
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
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) {
    throw StartError(kExitInput, file + ": is a folder. Name a readable file with --config.");
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw StartError(kExitInput, file + ": cannot be read. Name a readable file with --config.");
  }
  std::stringstream text;
  text << stream.rdbuf();
  const MessageText parsed(text.str(), file, "configuration", config);
  if (any_fault(parsed.problems())) {
    SceneProblem first = parsed.problems().front();
    if (first.remedy.empty()) first.remedy = "Fields are those of the options, '-' written '_'.";
    throw StartError(kExitInput, to_text(first));
  }
  if (const std::optional<wire::UnknownChoice> unknown = wire::unknown_choice(config)) {
    SceneProblem problem;
    problem.field = unknown->path;
    problem.message = unknown->message;
    throw StartError(kExitInput, to_text(parsed.located(problem)));
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
           "' is not known. Give WHAT or WHAT:SEED, such as nan:7; WHAT is " + kinds_of_fault() +
           ".");
  }
  check_name("--record", config.record());
  check_name("--scene", config.scene());
  check_name("--gesture", config.gesture());
  check_name("--keys", config.keys());
  check_name("--stop-key", config.stop_key());
  check_name("--stop-listen", config.stop_listen());
  if (config.has_cpu() && config.cpu() > kMaxCpu) refuse("--cpu: not in [0, 1023].");
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
  if (options.announce && config.keys().empty()) {
    refuse(
        "--announce: only a hapticd with keys is announced. Make keys with 'hapticctl keygen DIR', "
        "and give --keys DIR.");
  }
  options.config = std::move(config);
}

bool read_options(int argc, const char* const* argv, DaemonOptions& options) {
  CLI::App app(
      "hapticd: a daemon for 6-DoF haptic rendering. Started with nothing, it plays the Guqin with "
      "a simulated device and a demonstration gesture, and serves clients on 127.0.0.1:47800.",
      "hapticd");
  app.set_version_flag("--version", "hapticd " HAPTICD_VERSION);
  app.footer(
      "hapticd doctor examines the machine: hapticd doctor --help. hapticd device list names\n"
      "the devices that are plugged in; hapticd export writes a recording as a table.\n"
      "Exit codes: 0 good, 1 bad scene, gesture, profile or configuration, 2 bad command line,\n"
      "3 address not available, 4 realtime required and refused, 5 a verified replay differs,\n"
      "6 doctor named a cause, 7 the requested recording cannot be started, 8 a verified replay\n"
      "is of other physics, and its poses alone are the same.");
  add_options(app, options);
  const std::string empty =
      hints::fault_of_empty_option(app, {argv, static_cast<std::size_t>(argc)});
  if (!empty.empty()) refuse(empty + " See hapticd --help.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    app.exit(success);
    return false;
  } catch (const CLI::ParseError& error) {
    const std::vector<std::string> rest = app.remaining();
    const std::string meant = rest.empty() ? "" : hints::did_you_mean(rest.front(), kCommandNames);
    const std::string fault = hints::command_line_fault(app, error);
    refuse(fault + (fault.ends_with('?') ? "" : meant) + " See hapticd --help.");
  }
  if (app.count("--record") > 0 && options.given.record().empty()) {
    refuse("--record: the name is empty. Give a file.");
  }
  settle_config(options);
  return true;
}

}  // namespace hapticd
