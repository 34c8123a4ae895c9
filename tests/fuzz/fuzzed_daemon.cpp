// See fuzzed_daemon.h.
#include "tests/fuzz/fuzzed_daemon.h"

#include <spdlog/spdlog.h>

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "tests/fuzz/plain_line.h"
#include "tests/fuzz/scratch_folder.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;
/// Milliseconds that an answer may take: what comes in several datagrams needs some of them.
constexpr int kPatience = 40;
constexpr std::uint32_t kBootId = 5;

constexpr const char* kScene = R"(
name: "strings"
tools {
  tool_id: 3
  name: "finger"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0, 0.02, 0] }
}
tools {
  tool_id: 7
  name: "thumb"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0.1, 0.02, 0] }
}
strings { name: "C2" p_wa_m: [-0.5, 0, 0] p_wb_m: [0.5, 0, 0] frequency_hz: 65.4 }
strings { name: "G2" p_wa_m: [-0.5, 0, 0.02] p_wb_m: [0.5, 0, 0.02] frequency_hz: 98 }
bodies { name: "wall" shape { spheres { centre_m: [0, -1000, 0] radius_m: 999 } } }
vibration {}
tones {}
)";
constexpr const char* kGesture = R"(
name: "press"
tracks {
  tool_id: 3
  waypoints { at_string { string_index: 0 lambda: 0.5 offset_m: [0, 0.02, 0] } }
  waypoints { at_string { string_index: 0 lambda: 0.5 offset_m: [0, 0.004, 0] } duration_s: 0.01 }
}
)";
constexpr const char* kProfile = R"(
name: "fuzzed"
driver: DRIVER_SIMULATED
peak_force_n { value: 20 source: "chosen" }
peak_torque_n_m { value: 0.5 source: "chosen" }
damping_n_s_per_m { value: 2 source: "chosen" }
)";

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);
}

/// What is installed here, and where recordings go.
const ScratchFolder& installation() {
  static const ScratchFolder folder;
  [[maybe_unused]] static const bool made = [] {
    folder.write("scenes/strings.textproto", kScene);
    folder.write("gestures/press.textproto", kGesture);
    folder.write("devices/fuzzed.textproto", kProfile);
    // NOLINTBEGIN(concurrency-mt-unsafe): there is one thread yet
    setenv("HAPTICD_DATA", folder.path("").c_str(), 1);
    setenv("STATE_DIRECTORY", folder.path("state").c_str(), 1);
    // NOLINTEND(concurrency-mt-unsafe)
    spdlog::set_level(spdlog::level::off);
    return true;
  }();
  return folder;
}

DaemonPlan make_plan(bool virtual_clock) {
  installation().write("state/recordings/README", "nothing");
  DaemonPlan plan;
  v1::Config& given = plan.options.given;
  given.set_scene("strings");
  given.set_gesture("press");
  given.set_clock(virtual_clock ? v1::CLOCK_MODE_VIRTUAL : v1::CLOCK_MODE_REALTIME);
  for (const auto& [tool_id, source] : {std::pair(3U, "simulated"), std::pair(7U, "scripted")}) {
    v1::DeviceChoice& device = *given.add_device();
    device.set_tool_id(tool_id);
    device.set_source(source);
    device.set_profile("fuzzed");
  }
  settle_config(plan.options);
  plan.player = player_options(plan.options.config);
  return plan;
}

const Address kClient = ipv4_address({127, 0, 0, 1}, 4);

}  // namespace

FuzzedDaemon::FuzzedDaemon(bool virtual_clock)
    : plan_(make_plan(virtual_clock)),
      devices_(plan_.player, scenes_, loop_, clients_),
      loop_(clients_, false),
      recorder_(loop_.channels(), record_header(plan_)),
      scenes_(plan_, loop_, clients_, &recorder_),
      play_(plan_.player, scenes_, loop_),
      records_(&recorder_, clients_),
      quality_(plan_.player, scenes_, loop_, virtual_clock),
      states_(scenes_,
              [this](const Tick& tick, v1::State& state) { quality_.explain(tick, state); }) {
  loop_.begin(loop_options(), scenes_.first_scene(),
              [this](const LoopEvent& event) { take_event(event); });
  begin_time();
  requests_.emplace(Desks{loop_, assets_, scenes_, play_, records_, devices_, catalogues_, *time_},
                    clients_);
  const ServerOptions options{.boot_id = kBootId, .virtual_clock = virtual_clock};
  server_.emplace(options, host(), [this](const Address&, std::span<const std::uint8_t> bytes) {
    to_client_.emplace_back(bytes.begin(), bytes.end());
  });
  clients_.serve_by(*server_);
  client_.emplace(
      [this](std::span<const std::uint8_t> bytes) {
        to_server_.emplace_back(bytes.begin(), bytes.end());
      },
      [number = 1U]() mutable { return ++number; }, client::ClientHandlers{});
  acquire();
}

FuzzedDaemon::~FuzzedDaemon() { installation().remove("state"); }

LoopOptions FuzzedDaemon::loop_options() const {
  LoopOptions options;
  options.period_ns = plan_.player.period_ns;
  options.virtual_time = plan_.player.virtual_time;
  return options;
}

void FuzzedDaemon::begin_time() {
  if (plan_.player.virtual_time) {
    const auto hand_on = [this](std::int64_t) {
      loop_.take_events();
      take_ticks();
    };
    time_.emplace(std::in_place_type<VirtualTime>,
                  VirtualTime::Parts{loop_, clients_, recorder_, states_.hash(), hand_on},
                  plan_.player.period_ns);
  } else {
    time_.emplace(std::in_place_type<RealTime>, loop_.loop(), RealtimeOptions{});
  }
}

ServerHost FuzzedDaemon::host() {
  ServerHost host;
  host.greeting = [this] {
    std::vector<v1::Item> items(2);
    *items[0].mutable_scene_info() = scenes_.told().info;
    *items[1].mutable_record_info() = records_.told();
    return items;
  };
  host.request = [this](const RequestId& id, const v1::Item& item) {
    requests_->carry_out(id, item);
    judge();
  };
  host.abandoned = [this](const RequestId& id) { requests_->abandon(id); };
  host.fill_state = [this](const Subscription& subscription, v1::State& state) {
    states_.fill(subscription, state);
  };
  host.lease_lost = [this](LeaseEnd) {
    assets_.forget_unfinished();
    play_.forget_poses();
    loop_.lose_lease();
  };
  return host;
}

void FuzzedDaemon::judge() {
  const SceneIndex& index = scenes_.newest().index;
  judge_.look(loop_.channels(), {index.tool_ids.size(), scenes_.newest().settings.pieces.size(),
                                 loop_.next_tick(), loop_.lease_ends()});
  if (!std::holds_alternative<VirtualTime>(*time_)) return;
  loop_.loop().take_commands();
  loop_.take_events();
}

void FuzzedDaemon::take_event(const LoopEvent& event) {
  devices_.take(event);
  scenes_.take(event);
  if (!std::holds_alternative<SceneSwapped>(event.what)) return;
  play_.forget_poses();
  states_.restart_hash();
}

void FuzzedDaemon::take_ticks() {
  while (states_.take(loop_.channels().ticks)) {
    const Tick& tick = states_.newest();
    judge_tick(tick, loop_.loop().scene());
    loop_.note(tick);
    devices_.take(tick);
    quality_.follow(tick);
    if (std::holds_alternative<VirtualTime>(*time_)) states_.add_to_hash();
    server_->offer_tick(tick.tick, tick.scene_id, now_ns_);
    scenes_.forget_before(tick.scene_id);
  }
}

/// As Daemon does it.
void FuzzedDaemon::work() {
  loop_.tell_lease_ends();
  scenes_.work();
  judge();
  if (!std::holds_alternative<VirtualTime>(*time_)) loop_.loop().tick_once(now_ns_);
  std::visit([this](auto& time) { static_cast<void>(time.pass(now_ns_)); }, *time_);
  loop_.take_events();
  scenes_.carry_out_held();
  judge();
  take_ticks();
  records_.report();
}

void FuzzedDaemon::pass() {
  now_ns_ += kMs;
  client_->poll(now_ns_);
  for (const Datagram& datagram : std::exchange(to_server_, {})) {
    server_->receive(kClient, datagram, now_ns_);
  }
  server_->poll(now_ns_);
  work();
  server_->poll(now_ns_);
  for (const Datagram& datagram : std::exchange(to_client_, {})) {
    client_->receive(datagram, now_ns_);
  }
}

void FuzzedDaemon::take_result(const v1::Result& result) {
  good_ = result.code() == v1::RESULT_CODE_OK;
  require(v1::ResultCode_IsValid(result.code()) && result.code() != v1::RESULT_CODE_UNSPECIFIED,
          "an answer that says nothing");
  require(good_ || !result.message().empty(), "a refusal without a reason");
  require(result.message().size() <= 400 && is_plain_line(result.message(), true),
          "a message that is long, or obeyed by a terminal");
  require(result.path().size() <= 256 && is_plain_line(result.path()),
          "a path that is long, or obeyed by a terminal");
}

void FuzzedDaemon::request(const v1::Item& item) {
  ++waiting_;
  const std::uint64_t id =
      client_->request(item, [this, answered = false](const v1::Result* result) mutable {
        require(!std::exchange(answered, true), "a request has two answers");
        --waiting_;
        if (result != nullptr) take_result(*result);
      });
  if (id == 0 || item.has_pose_batch()) --waiting_;
}

void FuzzedDaemon::acquire() {
  v1::Item item;
  item.mutable_acquire();
  request(item);
  for (int k = 0; k < kPatience && server_->fence() == 0; ++k) pass();
}

bool FuzzedDaemon::ask(const v1::Item& item) {
  if (server_->fence() == 0) acquire();
  good_ = item.has_pose_batch();
  request(item);
  for (int k = 0; k < kPatience && (k < 3 || waiting_ > 0); ++k) pass();
  while (scenes_.loading()) {
    std::this_thread::yield();
    pass();
  }
  return good_;
}

void FuzzedDaemon::end() {
  client_->leave(now_ns_);
  for (int k = 0; k < 3 * kPatience && !client_->over(); ++k) pass();
  require(client_->over() && waiting_ == 0, "a request has no answer");
  for (int k = 0; k < kPatience && server_->session_count() > 0; ++k) {
    now_ns_ += 1000 * kMs;
    pass();
  }
  require(server_->session_count() == 0 && server_->fence() == 0, "a client is not forgotten");
}

}  // namespace hapticd::test
