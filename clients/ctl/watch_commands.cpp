// status and watch: what the daemon does, once or live. Not RT.
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "clients/ctl/commands.h"
#include "clients/ctl/device_text.h"
#include "clients/ctl/terminal.h"
#include "clients/ctl/text.h"
#include "clients/ctl/view.h"

namespace hapticd::ctl {
namespace {

using Json = nlohmann::ordered_json;

/// How long status waits for a State: with the virtual clock at rest none may come.
constexpr std::chrono::milliseconds kStateWait{500};
constexpr std::size_t kTonesShown = 5;
/// States per second asked for.
constexpr double kWatchRate = 100.0;

const std::vector<v1::Section> kSections{
    v1::SECTION_TOOLS,   v1::SECTION_STRINGS,  v1::SECTION_CONTACTS, v1::SECTION_TIMING,
    v1::SECTION_STAGES,  v1::SECTION_ENERGY,   v1::SECTION_QUALITY,  v1::SECTION_STIFFNESS,
    v1::SECTION_DEVICES, v1::SECTION_GESTURES, v1::SECTION_REPLAY};

std::atomic<bool> over{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void end_watch(int /*signal*/) { over.store(true); }

View view_of(const client::Client& client) {
  View view;
  view.server = client.server();
  if (client.scene()) view.scene = *client.scene();
  view.has_state = client.state().has_value();
  if (view.has_state) view.state = *client.state();
  view.lease = client.lease();
  view.silence_s =
      1e-9 * static_cast<double>(client::monotonic_now_ns() - client.core().heard_ns());
  return view;
}

/// Devices that get less force than they could, and what to do.
void print_unchecked(client::Client& client, const GlobalOptions& options) {
  v1::Item item;
  item.mutable_get_device_info();
  const v1::Result result = client.call(item, timeout_of(options));
  for (const v1::DeviceInfo& info : result.devices().devices()) {
    for (const std::string& notice : {unchecked_text(info), no_force_text(info)}) {
      if (!notice.empty()) print_text(notice);
    }
  }
}

/// What the daemon has counted on its network, by cause; empty where it is of an earlier version.
v1::Counts counts_of(client::Client& client, const GlobalOptions& options) {
  v1::Item item;
  item.mutable_get_counts();
  return client.call(item, timeout_of(options)).counts();
}

Json network_json(const v1::Counts& counts) {
  Json json = Json::object();
  for (const v1::Count& count : counts.counts()) json[count.cause()] = count.count();
  return json;
}

void status(const GlobalOptions& options) {
  const auto client = connect(options);
  require(client->subscribe(1, kSections));
  client->poll_until([&] { return client->state().has_value(); }, kStateWait);
  const View view = view_of(*client);
  const v1::Counts counts = counts_of(*client, options);
  if (!options.json) {
    for (const std::string& line : summary_lines(view)) print_text(line);
    print_text(network_line(counts));
    print_unchecked(*client, options);
    return;
  }
  const Json json = {{"server", view.server},
                     {"server_version", view.scene.server_version()},
                     {"scene", view.scene.scene().name()},
                     {"rate_hz", view.scene.rate_hz()},
                     {"next_tick", view.scene.next_tick()},
                     {"lease", Json::parse(to_json(view.lease))},
                     {"network", network_json(counts)},
                     {"state", view.has_state ? Json::parse(to_json(view.state)) : Json()}};
  print_text(to_json(json));
}

void watch(const GlobalOptions& options) {
  refuse_json(options, "watch draws on a terminal; use status --json in scripts");
  if (isatty(STDOUT_FILENO) == 0) {
    throw Failure(kUsageBad, "watch draws on a terminal; use status --json in scripts");
  }
  std::deque<v1::Tone> tones;
  TickHistogram ticks;
  client::ClientHandlers handlers;
  handlers.item = [&](const v1::Item& item) {
    if (!item.has_tone()) return;
    tones.push_front(item.tone());
    if (tones.size() > kTonesShown) tones.pop_back();
  };
  handlers.state = [&](const v1::State& state) {
    if (state.has_timing()) ticks.add(state.timing().last_ns());
  };
  const auto client = connect(options, handlers);
  const std::uint32_t divisor = client::state_divisor(client->scene()->rate_hz(), kWatchRate);
  require(client->subscribe(divisor, kSections));
  std::signal(SIGINT, end_watch);
  std::signal(SIGTERM, end_watch);
  const Terminal terminal;
  std::int64_t drawn_ns = 0;
  while (!over.load() && Terminal::key() != 'q') {
    client->poll();
    const std::int64_t now_ns = client::monotonic_now_ns();
    if (1e-9 * static_cast<double>(now_ns - drawn_ns) < kRedraw) continue;
    drawn_ns = now_ns;
    View view = view_of(*client);
    view.ticks = ticks;
    view.tones = tones;
    const TerminalSize size = Terminal::size();
    Terminal::draw(screen_lines(view, size.columns, size.rows));
  }
}

}  // namespace

void add_status_command(CLI::App& app, const GlobalOptions& options) {
  app.add_subcommand("status", "What the daemon does: state, force, times of the loop")
      ->callback([&options] { status(options); });
}

void add_watch_command(CLI::App& app, const GlobalOptions& options) {
  app.add_subcommand("watch", "The same live, with contacts, strings and tones; q quits")
      ->callback([&options] { watch(options); });
}

}  // namespace hapticd::ctl
