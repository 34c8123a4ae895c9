// Start, the network thread's work, the end. See daemon.h.
#include "server/daemon/daemon.h"

#include <sodium.h>
#include <spdlog/spdlog.h>

#include <cmath>

#include "server/daemon/log_text.h"
#include "server/daemon/record_info.h"

namespace hapticd {
namespace {

/// Longest wait at the end for force to ramp out and clients to hear Bye, ns.
constexpr std::int64_t kMaxEnd_ns = 1'500'000'000;

PlayerOptions player_options(const v1::Config& config) {
  PlayerOptions player;
  for (const v1::DeviceChoice& device : config.device()) {
    ProfileResult profile = load_profile(device.profile(), installed_profiles());
    if (!profile.loaded) {
      std::string text;
      for (const SceneProblem& problem : profile.problems) text += to_text(problem) + "\n";
      throw StartError(kExitInput, text.substr(0, text.size() - 1));
    }
    player.devices.push_back({device.tool_id(), std::move(*profile.loaded), device.source()});
  }
  player.period_ns = std::llround(1e9 / config.rate());
  player.virtual_time = config.clock() == v1::CLOCK_MODE_VIRTUAL;
  if (!config.inject().empty()) player.injection = parse_injection(config.inject());
  follow_config(config, player);
  return player;
}

std::uint32_t random_boot_id() {
  std::uint32_t id = 0;
  while (id == 0) randombytes_buf(&id, sizeof(id));
  return id;
}

std::optional<noise::KeyPair> keys_of(const v1::Config& config) {
  if (config.keys().empty()) return std::nullopt;
  try {
    return noise::read_key_folder(config.keys());
  } catch (const std::runtime_error& error) {
    throw StartError(kExitInput, std::string("--keys: ") + error.what());
  }
}

}  // namespace

Daemon::Daemon(DaemonOptions options)
    : options_(std::move(options)),
      replay_(open_replay(options_)),
      player_(replay_ ? recorded_player(replay_->header()) : player_options(options_.config)),
      virtual_time_(player_.virtual_time || replay_ != nullptr),
      channels_(std::make_unique<LoopChannels>()) {
  if (!options_.check_only) attach_devices();
  if (!replay_) recording_ = std::make_unique<Recording>(*channels_, record_header());
  LoopOptions loop;
  loop.period_ns = player_.period_ns;
  loop.virtual_time = player_.virtual_time;
  loop.guards_armed =
      player_.injection.has_value() || (replay_ && !options_.config.inject().empty());
  loop.images = !replay_;
  try {
    loop_ = std::make_unique<HapticLoop>(loop, first_scene(), *channels_);
  } catch (const StartError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw StartError(kExitInput, error.what());
  }
  if (replay_) begin_replay();
  ServerOptions server;
  server.boot_id = random_boot_id();
  server.virtual_clock = virtual_time_;
  server.keys = keys_of(options_.config);
  if (options_.check_only) return;
  try {
    transport_ = std::make_unique<UdpTransport>(options_.config.listen(), server.keys.has_value());
  } catch (const std::runtime_error& error) {
    throw StartError(kExitAddress, std::string("--listen: ") + error.what());
  }
  server_ = std::make_unique<ProtocolServer>(
      server, make_host(), [this](const Address& to, std::span<const std::uint8_t> datagram) {
        transport_->send(to, datagram);
      });
  // Read before anybody is served: nobody's Stop waits for the first to ask.
  static_cast<void>(catalogues_.scenes());
  static_cast<void>(catalogues_.gestures());
  static_cast<void>(catalogues_.recordings());
}

Daemon::~Daemon() = default;

std::unique_ptr<PlayedScene> Daemon::first_scene() {
  if (replay_) return make_recorded_scene(replay_->first_scene());
  LoadResult result = load_scene(options_.config.scene(), load_options());
  std::string faults;
  for (const SceneProblem& problem : result.problems) {
    if (problem.doubt) {
      spdlog::warn("{}", to_text(problem));
    } else {
      faults += (faults.empty() ? "" : "\n") + to_text(problem);
    }
  }
  if (result.loaded == nullptr) throw StartError(kExitInput, faults);
  LiveScene& scene = begin_playing(std::move(result.loaded));
  return make_played_scene(scene.loaded, scene.id, first_gesture(*scene.loaded), player_);
}

ServerHost Daemon::make_host() {
  ServerHost host;
  host.greeting = [this] {
    std::vector<v1::Item> items(2);
    *items[0].mutable_scene_info() = playing(playing_id_).info;
    *items[1].mutable_record_info() = record_info(told_record_);
    return items;
  };
  host.request = [this](const RequestId& id, const v1::Item& item) { request(id, item); };
  host.abandoned = [this](const RequestId& id) {
    if (steps_ && steps_->request == id) end_steps(v1::RESULT_CODE_OK);
    std::erase_if(held_, [&](const HeldRequest& held) { return held.id == id; });
  };
  host.fill_state = [this](const Subscription& subscription, v1::State& state) {
    encode_state(*snapshot_, playing(snapshot_->scene_id).index,
                 {subscription.sections, subscription.max_contacts}, state);
    const bool stages = subscription.has(v1::SECTION_STAGES);
    if (stages || subscription.has(v1::SECTION_TIMING)) {
      statistics_.fill(*snapshot_, stages, *state.mutable_timing());
    }
    explain_quality(*snapshot_, state);
    if (subscription.has(v1::SECTION_REPLAY)) fill_replay(state);
  };
  host.lease_lost = [this](LeaseEnd) {
    if (replay_) return;
    ++lease_ends_;
    next_pose_ticks_ = {};
    tell_lease_ends();
  };
  return host;
}

int Daemon::run(SignalRequests& signals) {
  begin_recording();
  if (!virtual_time_) {
    RealtimeOptions realtime;
    realtime.period_ns = player_.period_ns;
    if (options_.config.pace() == v1::PACE_DEVICE) realtime.pace = pace_source();
    realtime.required = options_.config.realtime() == v1::REALTIME_POLICY_REQUIRE;
    if (options_.config.has_cpu()) realtime.cpu = options_.config.cpu();
    try {
      thread_ = std::make_unique<RealtimeThread>(*loop_, realtime);
    } catch (const std::runtime_error& error) {
      take_back_recording();
      throw StartError(kExitRealtime, error.what());
    }
  }
  report_start();
  transport_->run(*server_, [&](std::int64_t now_ns) {
    follow_signals(signals, now_ns);
    return work(now_ns);
  });
  thread_.reset();
  take_events();
  const ServerCounters& counters = server_->counters();
  spdlog::info("ended; {} datagrams received, {} sent", counters.received, counters.sent);
  return exit_code_;
}

void Daemon::follow_signals(SignalRequests& signals, std::int64_t now_ns) {
  if (signals.reload.exchange(false) && !replay_) reload();
  if (replay_ && (signals.end.load() || end_requested_) && ending_since_ns_ < 0) {
    end_replay(now_ns);
  } else if (signals.end.load() && ending_since_ns_ < 0) {
    ending_since_ns_ = now_ns;
    channels_->commands.push({0, EndCommand{}});
    server_->shut_down(v1::BYE_REASON_SHUTDOWN, "hapticd ends.", now_ns);
  }
}

// The ring may be full of other commands: then once more later.
void Daemon::tell_lease_ends() {
  if (told_lease_ends_ == lease_ends_) return;
  if (channels_->commands.push({++last_command_, LeaseLostCommand{lease_ends_}})) {
    told_lease_ends_ = lease_ends_;
    lease_end_command_ = last_command_;
  }
  if (virtual_time_) loop_->take_commands();
}

bool Daemon::work(std::int64_t now_ns) {
  tell_lease_ends();
  finish_build();
  reload_scene();
  bool again = false;
  if (replay_) {
    again = pass_replay(now_ns);
  } else if (virtual_time_) {
    again = pass_virtual_time(now_ns);
  }
  take_events();
  carry_out_held();
  take_snapshots(now_ns);
  finish_calibrations();
  if (recording_) report_recording();
  if (ending_since_ns_ >= 0) {
    const bool silent = virtual_time_ || thread_->over();
    if ((silent && server_->session_count() == 0) || now_ns - ending_since_ns_ > kMaxEnd_ns) {
      transport_->stop();
    }
  }
  return again;
}

void Daemon::take_events() {
  LoopEvent event;
  while (channels_->events.pop(event)) take_event(event);
  LogRecord record;
  while (channels_->log.pop(record)) write_log(record);
}

void Daemon::take_event(const LoopEvent& event) {
  if (const auto* done = std::get_if<CommandDone>(&event.what)) {
    note_push(done->number, event.t_ns);
    finish_command(done->number, true, Cause::kNone);
  } else if (const auto* refused = std::get_if<CommandRefused>(&event.what)) {
    finish_command(refused->number, false, refused->cause);
  } else if (const auto* swapped = std::get_if<SceneSwapped>(&event.what)) {
    delete swapped->retired;
    finish_swap(swapped->scene_id);
  } else if (const auto* retired = std::get_if<GestureRetired>(&event.what)) {
    delete retired->plan;
  } else if (const auto* settled = std::get_if<SettingsRetired>(&event.what)) {
    settle_change(*settled->change, settled->dropped);
    delete settled->change;
  } else {
    tell_clients(event);
  }
}

void Daemon::tell_clients(const LoopEvent& event) {
  const SceneIndex& index = playing(event.scene_id).index;
  const EventPlace place{event.tick, event.t_ns, event.tool_id};
  std::optional<v1::Item> item;
  if (const auto* string = std::get_if<StringEvent>(&event.what)) {
    item = encode_event(*string, place, index);
  } else if (const auto* touch = std::get_if<TouchEvent>(&event.what)) {
    item = encode_event(*touch, place, index);
  } else if (const auto* fault = std::get_if<FaultNotice>(&event.what)) {
    item = encode_fault(fault->cause, fault->latched, place);
  }
  if (!item) return;
  record_event(event, *item);
  server_->broadcast(*item);
}

void Daemon::take_snapshots(std::int64_t now_ns) {
  while (const Snapshot* snapshot = channels_->snapshots.front()) {
    snapshot_ = snapshot;
    statistics_.add(*snapshot);
    newest_state_ = snapshot->loop_state;
    newest_tick_ = snapshot->tick;
    for (std::size_t k = 0; k < snapshot->tools.size(); ++k) {
      stiffness_bounds_[k] = snapshot->tools[k].stiffness_bound;
      measured_delays_[k] = snapshot->tools[k].measured_delay;
    }
    note_no_force(*snapshot);
    watch_forces(*snapshot);
    follow_budget(*snapshot);
    if (virtual_time_) {
      const auto complete = [&](v1::State& state) { explain_quality(*snapshot, state); };
      add_state(*snapshot, playing(snapshot->scene_id).index, complete, hash_);
    }
    server_->offer_tick(snapshot->tick, snapshot->scene_id, now_ns);
    // Events overtake snapshots: only now nothing more is told of the scene before.
    if (snapshot->scene_id == playing_id_) {
      while (scenes_.front().id != playing_id_) scenes_.pop_front();
    }
    channels_->snapshots.release();
  }
}

void Daemon::report_start() const {
  const v1::Config& config = options_.config;
  spdlog::info("hapticd " HAPTICD_VERSION " plays {} at {} Hz ({}, {} device {})", config.scene(),
               config.rate(),
               virtual_time_                      ? "virtual clock"
               : config.pace() == v1::PACE_DEVICE ? "paced by the device"
                                                  : "real clock",
               config.device(0).source(), config.device(0).profile());
  if (!replay_) report_budget();
  if (thread_ != nullptr) {
    for (const MissingPrivilege& missing : thread_->missing()) {
      spdlog::warn("{}; {}", missing.what, missing.remedy);
    }
  }
  spdlog::info("listening on {}: hapticctl {}status", transport_->local_address(),
               config.keys().empty() ? "" : "--key " + config.keys() + "/control.key ");
}

}  // namespace hapticd
