// See daemon.h.
#include "server/daemon/daemon.h"

#include <sodium.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <utility>

#include "core/rt/memory_boundary.h"
#include "core/rt/thread_role.h"
#include "proto/wire/shown_text.h"
#include "server/daemon/command_to_reach.h"
#include "server/daemon/session_log.h"
#include "server/daemon/start_check.h"
#include "server/encoding/encode_event.h"
#include "server/service/passed_socket.h"

namespace hapticd {
namespace {

/// Longest wait at the end for force to ramp out and clients to hear Bye, ns.
constexpr std::int64_t kMaxEnd_ns = 1'500'000'000;

std::uint32_t random_boot_id() {
  std::uint32_t id = 0;
  while (id == 0) randombytes_buf(&id, sizeof(id));
  return id;
}

void log_keys(const KeyWatch& keys) {
  for (const std::string& problem : keys.problems())
    spdlog::warn("not used: {}", wire::shown_text(problem));
  const std::size_t clients = keys.keys().known.size() - 2;
  if (clients > 0) spdlog::info("keys of single clients: {}", clients);
}

void log_losses(const std::string& what) {
  if (!what.empty()) spdlog::warn("network: dropped or refused: {}", what);
}

void log_lease(const std::string& what) {
  if (!what.empty()) spdlog::info("the lease is {}", what);
}

}  // namespace

Daemon::Opened Daemon::open(DaemonOptions options) {
  std::unique_ptr<ReplayRun> replay = open_replay(options);
  PlayerOptions player =
      replay ? recorded_player(replay->header()) : player_options(options.config);
  return {{std::move(options), std::move(player), std::nullopt}, std::move(replay)};
}

Daemon::Daemon(DaemonOptions options) : Daemon(open(std::move(options))) {}

Daemon::Daemon(Opened opened)
    : plan_(std::move(opened.plan)),
      stepped_here_(plan_.player.virtual_time || opened.replay != nullptr),
      devices_(plan_.player, scenes_, loop_, clients_),
      loop_(clients_, stepped_here_),
      recorder_(opened.replay == nullptr ? make_recorder() : nullptr),
      scenes_(plan_, loop_, clients_, recorder_.get()),
      play_(plan_.player, scenes_, loop_),
      records_(recorder_.get(), clients_),
      quality_(plan_.player, scenes_, loop_, stepped_here_),
      states_(scenes_,
              [this](const Tick& tick, v1::State& state) { quality_.explain(tick, state); }),
      service_(plan_, scenes_, stepped_here_) {
  if (replays()) quality_.leave_work_alone();
  begin_loop(opened.replay.get());
  service_.begin();
  begin_time(std::move(opened.replay));
  begin_serving();
}

Daemon::~Daemon() = default;

std::unique_ptr<RecorderThread> Daemon::make_recorder() {
  if (!plan_.options.check_only) devices_.attach();
  return std::make_unique<RecorderThread>(loop_.channels(), record_header(plan_));
}

void Daemon::begin_loop(const ReplayRun* replay) {
  const PlayerOptions& player = plan_.player;
  LoopOptions options;
  options.period_ns = player.period_ns;
  options.virtual_time = player.virtual_time;
  options.guards_armed =
      player.injection.has_value() || (replay != nullptr && !plan_.options.config.inject().empty());
  options.snapshots = replay == nullptr;
  try {
    std::unique_ptr<PlayedScene> first =
        replay == nullptr ? scenes_.first_scene()
                          : scenes_.recorded_scene(replay->first_scene(), replay->path());
    loop_.begin(options, std::move(first), [this](const LoopEvent& event) { take_event(event); });
  } catch (const StartError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw StartError(kExitInput, error.what());
  }
}

void Daemon::begin_time(std::unique_ptr<ReplayRun> replay) {
  const v1::Config& config = plan_.options.config;
  const auto hand_on = [this](std::int64_t now_ns) {
    loop_.take_events();
    take_ticks(now_ns);
  };
  if (replay != nullptr) {
    time_.emplace(std::in_place_type<ReplayTime>,
                  ReplayTime::Parts{loop_, scenes_, clients_, hand_on}, std::move(replay), config);
  } else if (stepped_here_) {
    time_.emplace(std::in_place_type<VirtualTime>,
                  VirtualTime::Parts{loop_, clients_, *recorder_, states_.hash(), hand_on},
                  plan_.player.period_ns);
  } else {
    RealtimeOptions realtime;
    realtime.period_ns = plan_.player.period_ns;
    if (config.pace() == v1::PACE_DEVICE) realtime.pace = devices_.pace();
    realtime.required = config.realtime() == v1::REALTIME_POLICY_REQUIRE;
    if (config.has_cpu()) realtime.cpu = config.cpu();
    time_.emplace(std::in_place_type<RealTime>, loop_.loop(), realtime);
  }
}

void Daemon::begin_serving() {
  const v1::Config& config = plan_.options.config;
  ServerOptions options;
  options.boot_id = random_boot_id();
  options.virtual_clock = stepped_here_;
  options.period_ns = plan_.player.period_ns;
  read_keys();
  if (keys_.has_value()) options.keys = keys_->keys();
  options.old_handshake = plan_.options.old_handshake;
  const StopPlan stop = stop_plan(config);
  if (plan_.options.check_only) {
    check_start(config, stop);
    return;
  }
  bind();
  // A replay moves no device.
  if (!replays()) {
    stop_road_ = open_stop_road(stop, transport_->local_address(), loop_.channels().stop);
    if (stop_road_ != nullptr) plan_.stop_port = stop_road_->port();
  }
  requests_.emplace(Desks{loop_, assets_, scenes_, play_, records_, devices_, catalogues_, *time_},
                    clients_);
  server_ = std::make_unique<ProtocolServer>(
      options, make_host(), [this](const Address& to, std::span<const std::uint8_t> datagram) {
        transport_->send(to, datagram);
      });
  clients_.serve_by(*server_);
  // Read before anybody is served: nobody's Stop waits for the first to ask.
  static_cast<void>(catalogues_.scenes());
  static_cast<void>(catalogues_.gestures());
  static_cast<void>(catalogues_.recordings());
}

void Daemon::read_keys() {
  const std::string& folder = plan_.options.config.keys();
  if (folder.empty()) return;
  try {
    keys_.emplace(folder);
  } catch (const std::runtime_error& error) {
    throw StartError(kExitInput, std::string("--keys: ") + error.what());
  }
  log_keys(*keys_);
}

void Daemon::follow_keys(std::int64_t now_ns) {
  if (!keys_.has_value()) return;
  if (keys_->follow(now_ns)) {
    keys_changed_ = true;
    log_keys(*keys_);
  }
  if (!keys_changed_) return;
  server_->replace_keys(keys_->keys(), now_ns);
  keys_changed_ = false;
}

void Daemon::bind() {
  const std::string& listen = plan_.options.config.listen();
  const bool keyed = !plan_.options.config.keys().empty();
  bool passed = false;
  try {
    const std::optional<int> bound = passed_socket();
    passed = bound.has_value();
    transport_ = passed ? std::make_unique<UdpTransport>(BoundSocket{*bound}, keyed)
                        : std::make_unique<UdpTransport>(listen, keyed);
  } catch (const std::runtime_error& error) {
    throw StartError(kExitAddress, (passed ? "" : "--listen: ") + std::string(error.what()));
  }
  if (plan_.options.announce) service_.announce(*transport_);
}

ServerHost Daemon::make_host() {
  ServerHost host;
  host.greeting = [this] {
    std::vector<v1::Item> items(2);
    *items[0].mutable_scene_info() = scenes_.told().info;
    if (plan_.stop_port) items[0].mutable_scene_info()->set_stop_port(*plan_.stop_port);
    if (std::holds_alternative<VirtualTime>(*time_)) {
      items[0].mutable_scene_info()->set_next_tick(loop_.loop().next_tick());
    }
    *items[1].mutable_record_info() = records_.told();
    return items;
  };
  host.request = [this](const RequestId& id, const v1::Item& item) {
    requests_->carry_out(id, item);
  };
  host.abandoned = [this](const RequestId& id) { requests_->abandon(id); };
  host.fill_state = [this](const Subscription& subscription, v1::State& state) {
    states_.fill(subscription, state);
    const auto* replay = std::get_if<ReplayTime>(&*time_);
    if (replay == nullptr || !subscription.has(v1::SECTION_REPLAY)) return;
    replay->fill(states_.newest().tick, *state.mutable_replay());
  };
  host.lease_lost = [this](LeaseEnd) {
    if (replays()) return;
    assets_.forget_unfinished();
    play_.forget_poses();
    loop_.lose_lease();
  };
  host.lease_told = [this](const v1::LeaseInfo& lease) {
    within_memory([&] { leases_.note(lease); });
  };
  host.session = [](const SessionNotice& notice) { log_session(notice); };
  return host;
}

void Daemon::start_time() {
  const std::string& file = plan_.options.config.record();
  records_.begin(file);
  try {
    std::visit([](auto& time) { time.start(); }, *time_);
  } catch (const std::runtime_error& error) {
    if (!file.empty()) {
      // hapticd does not start after all.
      recorder_.reset();
      std::error_code ignored;
      std::filesystem::remove(file, ignored);
    }
    throw StartError(kExitRealtime, error.what());
  }
}

int Daemon::run(SignalRequests& signals) {
  start_time();
  if (stop_road_ != nullptr) stop_road_->start();
  report_start();
  // All is open that only a start needs.
  begin_role(ThreadRole::kNetwork);
  transport_->run(*server_, [&](std::int64_t now_ns) {
    follow_signals(signals, now_ns);
    return work(now_ns);
  });
  if (auto* time = std::get_if<RealTime>(&*time_)) time->stop();
  loop_.take_events();
  const ServerCounters& counters = server_->counters();
  log_losses(losses_.rest(counters));
  log_lease(leases_.rest());
  spdlog::info("ended; {} datagrams received, {} sent", counters.received, counters.sent);
  const auto* replay = std::get_if<ReplayTime>(&*time_);
  return replay == nullptr ? kExitGood : replay->exit_code();
}

void Daemon::follow_signals(SignalRequests& signals, std::int64_t now_ns) {
  if (signals.reload.exchange(false) && !replays()) {
    service_.reload();
    scenes_.reload();
  }
  if (ending_since_ns_ >= 0) return;
  if (auto* replay = std::get_if<ReplayTime>(&*time_)) {
    if (signals.end.load() || replay->end_asked()) replay->end();
  } else if (signals.end.load()) {
    loop_.end();
    end("hapticd ends.", now_ns);
  }
}

void Daemon::end(const char* why, std::int64_t now_ns) {
  ending_since_ns_ = now_ns;
  service_.end();
  server_->shut_down(v1::BYE_REASON_SHUTDOWN, why, now_ns);
}

bool Daemon::work(std::int64_t now_ns) {
  if (stop_road_ != nullptr) server_->note_stop_road(stop_road_->counters());
  loop_.tell_lease_ends();
  within_memory([&] { scenes_.work(); });
  const bool again = std::visit([&](auto& time) { return time.pass(now_ns); }, *time_);
  const auto* replay = std::get_if<ReplayTime>(&*time_);
  if (replay != nullptr && replay->ended() && ending_since_ns_ < 0) {
    end("The replay is over.", now_ns);
  }
  loop_.take_events();
  within_memory([&] { scenes_.carry_out_held(); });
  take_ticks(now_ns);
  within_memory([&] { devices_.work(); });
  within_memory([&] { records_.report(); });
  within_memory([&] { service_.follow(now_ns); });
  within_memory([&] { follow_keys(now_ns); });
  within_memory([&] { log_losses(losses_.next(server_->counters(), now_ns)); });
  within_memory([&] { log_lease(leases_.next(now_ns)); });
  if (ending_since_ns_ >= 0) {
    const bool over = std::visit([](const auto& time) { return time.over(); }, *time_);
    if ((over && server_->session_count() == 0) || now_ns - ending_since_ns_ > kMaxEnd_ns) {
      transport_->stop();
    }
  }
  return again;
}

void Daemon::take_event(const LoopEvent& event) {
  devices_.take(event);
  within_memory([&] { scenes_.take(event); });
  if (std::holds_alternative<SceneSwapped>(event.what)) {
    play_.forget_poses();
    states_.restart_hash();
  }
  const auto* fault = std::get_if<FaultNotice>(&event.what);
  if (fault != nullptr && fault->latched && stepped_here_) play_.forget_poses();
  tell_clients(event);
}

void Daemon::tell_clients(const LoopEvent& event) {
  const EventPlace place{event.tick, event.t_ns, event.tool_id};
  std::optional<v1::Item> item;
  if (const auto* string = std::get_if<StringEvent>(&event.what)) {
    item = encode_event(*string, place, scenes_.playing(event.scene_id).index);
  } else if (const auto* touch = std::get_if<TouchEvent>(&event.what)) {
    item = encode_event(*touch, place, scenes_.playing(event.scene_id).index);
  } else if (const auto* fault = std::get_if<FaultNotice>(&event.what)) {
    item = encode_fault(fault->cause, fault->latched, place);
  }
  if (!item) return;
  within_memory([&] { states_.note(event.scene_id, *item); });
  within_memory([&] { records_.note(event, *item); });
  clients_.tell(*item);
}

void Daemon::take_ticks(std::int64_t now_ns) {
  while (states_.take(loop_.channels().ticks)) {
    const Tick& tick = states_.newest();
    loop_.note(tick);
    service_.note(tick);
    devices_.take(tick);
    // A replay feels nothing.
    if (!replays()) within_memory([&] { devices_.watch_forces(tick); });
    within_memory([&] { quality_.follow(tick); });
    if (stepped_here_) add_to_hash();
    server_->offer_tick(tick.tick, tick.scene_id, now_ns);
    // Events overtake ticks: only now nothing more is told of the scene before.
    scenes_.forget_before(tick.scene_id);
  }
}

void Daemon::add_to_hash() {
  auto* time = std::get_if<VirtualTime>(&*time_);
  // A hash without one of the ticks must not be told as that of all.
  if (!within_memory([&] { states_.add_to_hash(); }) && time != nullptr) time->fail_steps();
}

void Daemon::report_start() const {
  const v1::Config& config = plan_.options.config;
  spdlog::info("hapticd " HAPTICD_VERSION " plays {} at {} Hz ({}, {} device {})", config.scene(),
               config.rate(),
               stepped_here_                      ? "virtual clock"
               : config.pace() == v1::PACE_DEVICE ? "paced by the device"
                                                  : "real clock",
               config.device(0).source(), config.device(0).profile());
  if (!replays()) warn_of_no_bound(plan_.player);
  if (const auto* time = std::get_if<RealTime>(&*time_)) {
    for (const MissingPrivilege& missing : time->missing()) {
      spdlog::warn("{}; {}", missing.what, missing.remedy);
    }
  }
  const std::string address = transport_->local_address();
  spdlog::info("listening on {}: {}", address, command_to_reach(address, config.keys()));
}

}  // namespace hapticd
