// Commands that are one request each: scenes, parameters, force, recorder, time. Not RT.
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <string_view>
#include <utility>

#include "clients/ctl/commands.h"
#include "clients/ctl/text.h"
#include "clients/library/scene_file.h"
#include "proto/hints/whole_number_option.h"
#include "proto/wire/shown_text.h"

namespace hapticd::ctl {
namespace {

/// Building a large scene may take this long, s.
constexpr double kSceneTimeout = 120.0;
/// What stands in the daemon's messages before the line of a text that was sent.
constexpr std::string_view kTextWithoutFile = "inline:";
/// Of files from this size on a terminal shows how far they are, bytes: others take a moment.
constexpr std::size_t kShownFile = 1'000'000;
/// Takes a line of a terminal away.
constexpr const char* kNoLine = "\r\x1b[K";

using Strings = std::shared_ptr<std::vector<std::string>>;

void print_done(const GlobalOptions& options, const v1::Result& result, const char* text) {
  print_text(options.json ? to_json(result) : text);
}

/// What is said of a subcommand.
struct Wording {
  const char* name;
  const char* help;
  const char* done;  ///< once it has been obeyed
};

/// A subcommand that makes one request under the lease.
void add_control(CLI::App& app, const GlobalOptions& options, const Wording& words,
                 const v1::Item& item) {
  app.add_subcommand(words.name, words.help)->callback([&options, item, done = words.done] {
    const auto client = connect(options);
    print_done(options, control(*client, item, options), done);
  });
}

/// A subcommand that prints a listing.
void add_listing(CLI::App& app, const GlobalOptions& options, const char* help,
                 const v1::Item& item) {
  app.add_subcommand("list", help)->callback([&options, item] {
    const auto client = connect(options);
    const v1::Result result = ask(*client, item, options);
    if (options.json) {
      print_text(to_json(result.listing()));
      return;
    }
    const v1::Listing& listing = result.listing();
    for (int i = 0; i < listing.names_size(); ++i) {
      const bool described = i < listing.descriptions_size();
      print_row(listing.names(i), described ? listing.descriptions(i) : "");
    }
  });
}

void show_progress(const client::SceneAssetFile& asset, std::size_t there, std::size_t all) {
  if (all < kShownFile || isatty(STDERR_FILENO) == 0) return;
  std::fprintf(stderr, "%ssending %s: %zu %%", kNoLine, wire::shown_text(asset.name).c_str(),
               100 * there / all);
  if (there == all) std::fputs(kNoLine, stderr);
}

/// Text and files of a scene in a file; no more than its name for an installed one.
client::SceneFile scene_of(const std::string& source, v1::Item& request) {
  client::SceneFile scene;
  if (!names_file(source)) {
    request.mutable_load_scene()->set_name(source);
    return scene;
  }
  try {
    scene = client::read_scene_file(source, read_source(source));
  } catch (const Failure&) {
    throw;
  } catch (const std::runtime_error& fault) {
    throw Failure(kRefused, fault.what());
  }
  request = client::load_request(scene);
  return scene;
}

/// What the daemon says of a text, of which it does not know that it is of the file `source`.
std::string with_file(std::string text, const std::string& source) {
  // The first fault may follow a code, each other one begins a line.
  std::size_t place = text.find(kTextWithoutFile);
  while (place != std::string::npos) {
    text.replace(place, kTextWithoutFile.size(), source + ":");
    place = text.find("\n" + std::string(kTextWithoutFile), place + source.size());
    if (place != std::string::npos) ++place;
  }
  return text;
}

void load(const GlobalOptions& options, const std::string& source, bool check_only) {
  v1::Item item;
  const client::SceneFile scene = scene_of(source, item);
  item.mutable_load_scene()->set_check_only(check_only);
  require_utf8(item);
  GlobalOptions patient = options;
  patient.timeout_s = std::max(options.timeout_s, kSceneTimeout);
  const auto client = connect(options);
  try {
    client::Controller controller(*client);
    acquire(controller, *client, patient);
    v1::Result result = client::bring_assets(controller, scene, show_progress, timeout_of(patient));
    if (result.code() == v1::RESULT_CODE_OK) result = controller.call(item, timeout_of(patient));
    controller.release();
    require(result);
    result.set_message(with_file(result.message(), source));
    print_done(options, result, check_only ? "good" : "loaded");
    // What of the scene is without effect.
    if (!result.message().empty()) print_problem(result.message());
  } catch (const Refusal& refusal) {
    if (!names_file(source)) throw;
    v1::Result result = refusal.result();
    result.set_message(with_file(result.message(), source));
    throw Refusal(result, with_file(refusal.what(), source));
  }
}

void add_load(CLI::App& app, const GlobalOptions& options, const char* name, const char* help,
              bool check_only) {
  const auto source = std::make_shared<std::string>();
  CLI::App& command = *app.add_subcommand(name, help);
  command
      .add_option("SCENE", *source,
                  "name of an installed scene, or a file: with a . or / in its name")
      ->required();
  command.callback([&options, source, check_only] { load(options, *source, check_only); });
}

void get(const GlobalOptions& options, const std::vector<std::string>& paths) {
  v1::Item item;
  item.mutable_get_parameters();
  for (const std::string& path : paths) {
    if (path.empty()) {
      throw Failure(kUsageBad, "a path is empty. Give one such as strings[*].tension_n, or none.");
    }
    item.mutable_get_parameters()->add_paths(path);
  }
  const auto client = connect(options);
  const v1::Result result = ask(*client, item, options);
  if (options.json) {
    print_text(to_json(result.parameters()));
    return;
  }
  for (const v1::Assignment& value : result.parameters().values()) {
    print_text(to_text(value));
  }
}

void set(const GlobalOptions& options, const std::vector<std::string>& assignments) {
  v1::Item item;
  for (const std::string& text : assignments) {
    *item.mutable_set_parameter()->add_assignments() = parse_assignment(text);
  }
  const auto client = connect(options);
  print_done(options, control(*client, item, options), "set");
}

v1::Item run_item(v1::RunMode mode) {
  v1::Item item;
  item.mutable_run()->set_mode(mode);
  return item;
}

void step(const GlobalOptions& options, std::uint64_t steps) {
  v1::Item item = run_item(v1::RUN_MODE_STEP);
  item.mutable_run()->set_steps(steps);
  const auto client = connect(options);
  const v1::Result result = control(*client, item, options);
  if (options.json) {
    print_text(to_json(result.run()));
    return;
  }
  std::printf("%llu tick%s, next is tick %llu\nhash ",
              static_cast<unsigned long long>(result.run().steps()),
              result.run().steps() == 1 ? "" : "s",
              static_cast<unsigned long long>(result.run().next_tick()));
  for (const char byte : result.run().state_hash()) {
    std::printf("%02x", static_cast<unsigned>(static_cast<unsigned char>(byte)));
  }
  std::printf("\n");
}

void record(const GlobalOptions& options, v1::RecordMode mode, const std::string& file) {
  v1::Item item;
  item.mutable_record()->set_mode(mode);
  item.mutable_record()->set_file(file);
  const auto client = connect(options);
  v1::RecordInfo info;
  info.set_file(control(*client, item, options).recorded());
  info.set_state(mode == v1::RECORD_MODE_START ? v1::RECORD_STATE_RECORDING
                                               : v1::RECORD_STATE_WRITTEN);
  print_text(options.json ? to_json(info)
                          : plain_name(v1::RecordState_Name(info.state()), "RECORD_STATE_") + " " +
                                info.file());
}

void add_record(CLI::App& app, const GlobalOptions& options, const char* name, const char* help,
                v1::RecordMode mode) {
  const auto file = std::make_shared<std::string>();
  CLI::App& command = *app.add_subcommand(name, help);
  if (mode != v1::RECORD_MODE_STOP) {
    command.add_option("FILE", *file, "name in the daemon's folder of recordings");
  }
  command.callback([&options, file, mode] { record(options, mode, *file); });
}

void add_tool_option(CLI::App& command, const std::shared_ptr<std::uint32_t>& tool_id) {
  hints::takes_whole_number(
      command.add_option("--tool", *tool_id, "id of the tool, as the scene gives it"), 0,
      kMaxToolId)
      ->capture_default_str();
}

void add_tool_commands(CLI::App& app, const GlobalOptions& options) {
  const auto tool_id = std::make_shared<std::uint32_t>(0);
  CLI::App& home = *app.add_subcommand("recentre", "Brings the tool home");
  add_tool_option(home, tool_id);
  home.callback([&options, tool_id] {
    v1::Item item;
    item.mutable_recentre()->set_tool_id(*tool_id);
    const auto client = connect(options);
    print_done(options, control(*client, item, options), "done");
  });
  const auto what = std::make_shared<std::string>();
  CLI::App& clutch = *app.add_subcommand(
      "clutch", "Lets the device move without the tool (open), or with it again");
  clutch.add_option("STATE", *what, "open or close")
      ->required()
      ->check(CLI::IsMember({"open", "close"}));
  add_tool_option(clutch, tool_id);
  clutch.callback([&options, tool_id, what] {
    v1::Item item;
    item.mutable_clutch()->set_tool_id(*tool_id);
    item.mutable_clutch()->set_open(*what == "open");
    const auto client = connect(options);
    print_done(options, control(*client, item, options), "done");
  });
}

}  // namespace

void add_scene_commands(CLI::App& app, const GlobalOptions& options) {
  CLI::App& scene = *app.add_subcommand("scene", "Scenes: list, load, check");
  scene.require_subcommand(1);
  scene.fallthrough();
  v1::Item item;
  item.mutable_list_scenes();
  add_listing(scene, options, "Lists the installed scenes", item);
  add_load(scene, options, "load", "Replaces the scene being played", false);
  add_load(scene, options, "check", "Has the daemon check a scene without loading it", true);
}

void add_parameter_commands(CLI::App& app, const GlobalOptions& options) {
  const auto paths = std::make_shared<std::vector<std::string>>();
  CLI::App& getter = *app.add_subcommand("get", "Prints live parameters");
  getter.add_option("PATH", *paths, "such as strings[*].tension_n (default: all)");
  getter.callback([&options, paths] { get(options, *paths); });
  const auto values = std::make_shared<std::vector<std::string>>();
  CLI::App& setter = *app.add_subcommand("set", "Changes live parameters, all or none");
  setter.add_option("PATH=VALUE", *values, "such as strings[3].tension_n=80 quality=3")->required();
  setter.callback([&options, values] { set(options, *values); });
}

void add_force_commands(CLI::App& app, const GlobalOptions& options) {
  v1::Item item;
  item.mutable_engage();
  add_control(app, options, {"engage", "Switches the force on, within 200 ms", "engaged"}, item);
  item.mutable_disengage();
  add_control(app, options, {"disengage", "Switches the force off, within 50 ms", "released"},
              item);
  item.mutable_clear();
  add_control(app, options, {"clear", "Clears a latched fault", "cleared"}, item);
  add_tool_commands(app, options);
}

void add_record_commands(CLI::App& app, const GlobalOptions& options) {
  CLI::App& group = *app.add_subcommand("record", "Recordings: start, stop, dump, list");
  group.require_subcommand(1);
  group.fallthrough();
  add_record(group, options, "start", "Records until told to stop", v1::RECORD_MODE_START);
  add_record(group, options, "stop", "Closes the recording", v1::RECORD_MODE_STOP);
  add_record(group, options, "dump", "Writes the last 60 s", v1::RECORD_MODE_DUMP);
  v1::Item item;
  item.mutable_list_recordings();
  add_listing(group, options, "Lists the recordings", item);
}

void add_run_commands(CLI::App& app, const GlobalOptions& options) {
  CLI::App& group = *app.add_subcommand("run", "Time: step (virtual clock), live, stop");
  group.require_subcommand(1);
  group.fallthrough();
  add_control(group, options, {"live", "Ticks follow the clock", "live"},
              run_item(v1::RUN_MODE_LIVE));
  add_control(group, options, {"stop", "No ticks", "stopped"}, run_item(v1::RUN_MODE_STOP));
  const auto steps = std::make_shared<std::uint64_t>(1);
  CLI::App& stepper = *group.add_subcommand("step", "Advances the virtual clock");
  hints::takes_whole_number(stepper.add_option("TICKS", *steps, "how far, 1 to 1000000000"), 1,
                            1'000'000'000)
      ->capture_default_str();
  stepper.callback([&options, steps] { step(options, *steps); });
}

}  // namespace hapticd::ctl
