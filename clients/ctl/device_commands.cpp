// device list, info, monitor, calibrate, check: devices of this machine, and those that the daemon
// drives. Not RT.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <random>

#include "clients/ctl/commands.h"
#include "clients/ctl/daemon_program.h"
#include "clients/ctl/device_text.h"
#include "clients/ctl/guided_check.h"
#include "clients/ctl/terminal.h"
#include "clients/ctl/text.h"
#include "proto/hints/quantity_option.h"
#include "proto/hints/whole_number_option.h"
#include "proto/wire/whole_characters.h"

namespace hapticd::ctl {
namespace {

/// States per second asked for.
constexpr double kMonitorRate = 100.0;

struct MonitorChoice {
  std::optional<std::uint32_t> tool;
  double seconds = std::numeric_limits<double>::infinity();
};

void info(const GlobalOptions& options) {
  v1::Item item;
  item.mutable_get_device_info();
  const auto client = connect(options);
  const v1::Result result = ask(*client, item, options);
  if (options.json) {
    print_text(to_json(result.devices()));
    return;
  }
  for (const v1::DeviceInfo& device : result.devices().devices()) {
    for (const std::string& line : info_lines(device)) print_text(line);
  }
}

void subscribe(client::Client& client) {
  const std::uint32_t divisor = client::state_divisor(client.scene()->rate_hz(), kMonitorRate);
  require(client.subscribe(divisor, {v1::SECTION_DEVICES, v1::SECTION_TOOLS, v1::SECTION_TIMING}));
}

void print_states(const GlobalOptions& options, const MonitorChoice& choice) {
  client::ClientHandlers handlers;
  handlers.state = [&](const v1::State& state) {
    if (state.devices_size() == 0) return;  // of before it was asked for
    print_text(to_json(choice.tool ? only_tool(state, *choice.tool) : state));
    std::fflush(stdout);
  };
  const auto client = connect(options, handlers);
  Conversation person = with_terminal();  // before the first reading, which comes while subscribing
  subscribe(*client);
  const auto ended = [&] { return person.ended(); };
  Conversation silent{{}, {}, [] { return false; }};
  static_cast<void>(live_until(*client, silent, ended, choice.seconds));
}

void draw_states(const GlobalOptions& options, const MonitorChoice& choice) {
  const auto client = connect(options);
  Conversation person = with_terminal();
  subscribe(*client);
  const Terminal terminal;
  std::int64_t drawn_ns = 0;
  const auto draw = [&] {
    const std::int64_t now_ns = client::monotonic_now_ns();
    if (client->state() && 1e-9 * static_cast<double>(now_ns - drawn_ns) >= kRedraw) {
      drawn_ns = now_ns;
      std::vector<std::string> lines = reading_lines(*client->state(), choice.tool);
      lines.emplace_back("q quits");
      const TerminalSize size = Terminal::size();
      if (lines.size() > size.rows) lines.resize(size.rows);
      for (std::string& line : lines) line = wire::whole_characters(line, size.columns);
      Terminal::draw(lines);
    }
    return person.ended() || Terminal::key() == 'q';
  };
  Conversation silent{{}, {}, [] { return false; }};
  static_cast<void>(live_until(*client, silent, draw, choice.seconds));
}

void monitor(const GlobalOptions& options, const MonitorChoice& choice) {
  if (options.json) return print_states(options, choice);
  if (isatty(STDOUT_FILENO) == 0) {
    throw Failure(kUsageBad, "device monitor draws on a terminal; use --json in scripts");
  }
  draw_states(options, choice);
}

void add_monitor(CLI::App& device, const GlobalOptions& options) {
  CLI::App& command = *device.add_subcommand(
      "monitor", "Live readings: pose, buttons, switches, temperature, force; q quits");
  const auto choice = std::make_shared<MonitorChoice>();
  hints::takes_whole_number(command.add_option("--tool", choice->tool, "id of the tool (all)"), 0,
                            kMaxToolId)
      ->type_name("ID");
  hints::takes_unit(command.add_option("--for", choice->seconds, "how long, s (until q or Ctrl-C)"),
                    "s")
      ->check(CLI::PositiveNumber)
      ->type_name("SECONDS");
  command.callback([&options, choice] { monitor(options, *choice); });
}

void add_calibrate(CLI::App& device, const GlobalOptions& options) {
  struct Choice {
    std::uint32_t tool = 0;
    bool zero = false;
  };
  CLI::App& command =
      *device.add_subcommand("calibrate", "Runs the device's own calibration and keeps the result");
  const auto choice = std::make_shared<Choice>();
  hints::takes_whole_number(command.add_option("--tool", choice->tool, "id of the tool"), 0,
                            kMaxToolId)
      ->capture_default_str();
  command.add_flag("--zero", choice->zero, "take the present pose as zero instead");
  command.callback([&options, choice] {
    refuse_json(options, "a calibration reports to a person");
    const auto client = connect(options);
    run_calibration(*client, options, choice->tool, choice->zero, with_terminal());
  });
}

void add_check(CLI::App& device, const GlobalOptions& options) {
  CLI::App& command = *device.add_subcommand(
      "check",
      "Guided check of axes, signs, directions and damping; before it a device gets 0.3 N");
  const auto choice = std::make_shared<CheckChoice>();
  const auto seed = std::make_shared<std::optional<std::uint64_t>>();
  hints::takes_whole_number(command.add_option("--tool", choice->tool_id, "id of the tool"), 0,
                            kMaxToolId)
      ->capture_default_str();
  hints::takes_whole_number(command.add_option("--seed", *seed, "of the order of the pushes (any)"),
                            0, std::numeric_limits<std::uint64_t>::max())
      ->type_name("N");
  command.add_flag("--anyway", choice->anyway, "also a device that needs no check");
  command.callback([&options, choice, seed] {
    refuse_json(options, "a check talks with a person");
    choice->seed = seed->has_value() ? **seed : std::random_device{}();
    const auto client = connect(options);
    run_check(*client, options, *choice, with_terminal());
  });
}

}  // namespace

void add_device_commands(CLI::App& app, const GlobalOptions& options) {
  CLI::App& device = *app.add_subcommand("device", "Haptic devices: found, watched, checked");
  device.require_subcommand(1);
  device.add_subcommand("list", "What is plugged into this machine; no daemon needs to run")
      ->callback([&options] {
        std::vector<std::string> words{"device", "list"};
        if (options.json) words.emplace_back("--json");
        become_hapticd(words);
      });
  device.add_subcommand("info", "What the daemon knows of each device, and from where")
      ->callback([&options] { info(options); });
  add_monitor(device, options);
  add_calibrate(device, options);
  add_check(device, options);
}

}  // namespace hapticd::ctl
