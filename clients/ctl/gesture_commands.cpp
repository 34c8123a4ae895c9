// gesture list, gesture play, gesture end: what the simulated hand does. Not RT.
#include <cstdio>
#include <limits>
#include <map>
#include <memory>

#include "clients/ctl/commands.h"
#include "clients/ctl/text.h"
#include "proto/hints/whole_number_option.h"

namespace hapticd::ctl {
namespace {

struct PlayOptions {
  std::string source;
  std::string arm;
  std::uint64_t seed = 0;
  std::uint32_t repeat = 1;
  bool has_seed = false;
};

const std::map<std::string, v1::Arm> kArms{{"off", v1::ARM_OFF},
                                           {"light", v1::ARM_LIGHT},
                                           {"firm", v1::ARM_FIRM},
                                           {"adversarial", v1::ARM_ADVERSARIAL}};

void finish(const GlobalOptions& options, const v1::Item& item, const char* done) {
  const auto client = connect(options);
  const v1::Result result = control(*client, item, options);
  print_text(options.json ? to_json(result) : done);
}

void play(const GlobalOptions& options, const PlayOptions& choice) {
  v1::Item item;
  v1::PlayGesture& request = *item.mutable_play_gesture();
  if (names_file(choice.source)) {
    parse_text(read_source(choice.source), choice.source, *request.mutable_gesture());
  } else {
    request.set_name(choice.source);
  }
  if (!choice.arm.empty()) request.set_arm(kArms.at(choice.arm));
  if (choice.has_seed) request.set_seed(choice.seed);
  request.set_repeat(choice.repeat);
  finish(options, item, "playing");
}

void list(const GlobalOptions& options) {
  v1::Item item;
  item.mutable_list_gestures();
  const auto client = connect(options);
  const v1::Listing listing = ask(*client, item, options).listing();
  if (options.json) {
    print_text(to_json(listing));
    return;
  }
  for (int i = 0; i < listing.names_size(); ++i) {
    const bool described = i < listing.descriptions_size();
    print_row(listing.names(i), described ? listing.descriptions(i) : "");
  }
}

}  // namespace

void add_gesture_commands(CLI::App& app, const GlobalOptions& options) {
  CLI::App& group = *app.add_subcommand("gesture", "The simulated hand: list, play, end");
  group.require_subcommand(1);
  group.fallthrough();
  group.add_subcommand("list", "Lists the installed gestures")->callback([&options] {
    list(options);
  });
  const auto choice = std::make_shared<PlayOptions>();
  CLI::App& player = *group.add_subcommand("play", "Plays a gesture");
  player
      .add_option("GESTURE", choice->source,
                  "name of an installed gesture, or a file: with a . or / in its name")
      ->required();
  player.add_option("--arm", choice->arm, "how the hand holds the device (default: as before)")
      ->check(CLI::IsMember({"off", "light", "firm", "adversarial"}));
  hints::takes_whole_number(
      player.add_option("--seed", choice->seed, "of the tremor (default: the daemon's)"), 0,
      std::numeric_limits<std::uint64_t>::max())
      ->each([choice](const std::string&) { choice->has_seed = true; });
  hints::takes_whole_number(
      player.add_option("--repeat", choice->repeat, "how many times; 0: until told otherwise"), 0,
      std::numeric_limits<std::uint32_t>::max())
      ->capture_default_str();
  player.callback([&options, choice] { play(options, *choice); });
  group.add_subcommand("end", "Ends the gesture being played")->callback([&options] {
    v1::Item item;
    item.mutable_play_gesture();
    finish(options, item, "ended");
  });
}

}  // namespace hapticd::ctl
