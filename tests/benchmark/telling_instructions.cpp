// Plays a finger on a string in the haptic loop, and takes what it tells as the daemon's other
// threads do: the network offers every tick to clients, the recorder takes it into its ring in
// memory and, while a session is recorded, into a file. All in one thread, so that callgrind counts
// the instructions of each part by its function: what clients and recordings cost, and that the
// haptic thread does not know of them. Run by tests/benchmark/count_features. usage:
// telling_instructions [CASE]; without one it lists them.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/math/elementary.h"
#include "server/daemon/scene_player.h"
#include "server/encoding/encode_state.h"
#include "server/haptic_loop/haptic_loop.h"
#include "server/network/protocol_server.h"
#include "server/recorder/recorder.h"
#include "server/scene_io/profile_loader.h"

namespace hapticd::test {
namespace {

/// Ticks until the force is on, and the ones counted after them.
constexpr int kEngaging = 300;
constexpr int kTicks = 200;

constexpr const char* kScene = R"(
name: "string"
tools {
  name: "finger"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0, 0.01534, 0] }
}
strings { name: "C2" p_wa_m: [-0.55, 0, 0] p_wb_m: [0.55, 0, 0] frequency_hz: 65.4 }
vibration {}
)";

/// Who hears of the ticks.
struct Case {
  const char* name;
  int clients = -1;  ///< -1: no network at all
  bool recorder = false;
  bool file = false;
};

constexpr Case kCases[] = {
    {"told_nobody"},
    {"clients_0", 0},
    {"clients_1", 1},
    {"clients_32", 32},
    {"last_minute", -1, true},
    {"session_file", -1, true, true},
    {"all_of_it", 32, true, true},
};

std::shared_ptr<const LoadedScene> loaded_scene() {
  LoadResult result = load_scene_text(kScene, {});
  if (result.loaded == nullptr) throw std::runtime_error("the scene is refused");
  return std::move(result.loaded);
}

std::unique_ptr<PlayedScene> played(std::shared_ptr<const LoadedScene> scene) {
  const ProfileResult profile =
      load_profile(HAPTICD_SOURCE_DIR "/deploy/devices/ideal.textproto", ProfileFolders{});
  if (!profile.loaded.has_value()) throw std::runtime_error("the profile is refused");
  PlayerOptions options;
  options.devices.push_back({0, *profile.loaded, *parse_source("scripted")});
  options.virtual_time = true;
  return make_played_scene(std::move(scene), 1, nullptr, options);
}

std::string datagram_of(std::uint32_t session, char counter, const v1::Packet& packet) {
  std::string datagram{'H', 1, 5, 0, static_cast<char>(session), 0, 0, 0, counter};
  datagram.resize(16);
  packet.AppendToString(&datagram);
  return datagram;
}

/// A loop and those who hear of it.
struct Telling {
  explicit Telling(const Case& c) : index(index_scene(*scene->scene)) {
    subscribe(c.clients);
    if (!c.recorder) return;
    v1::RecordHeader header;
    header.set_period_ns(1'000'000);
    recorder.begin(header);
    v1::SceneRecord record;
    record.set_scene_id(1);
    recorder.add(RecordKind::kScene, 0, record);
    if (c.file && !recorder.start(file)) throw std::runtime_error("no file to record into");
  }
  Telling(const Telling&) = delete;
  Telling& operator=(const Telling&) = delete;
  ~Telling() {
    recorder.stop();
    std::filesystem::remove(file);
  }

  /// Time of the network stands still: nobody falls silent, and nothing is repeated.
  static constexpr std::int64_t kNow_ns = 1'000'000'000;

  /// Every client asks for every tick, and acknowledges all that it is told before the first.
  void subscribe(int clients) {
    v1::Packet ask;
    ask.set_first(1);
    ask.add_items()->mutable_subscribe()->set_divisor(1);
    for (int i = 0; i < clients; ++i) receive(i, 0, ask);
    server.poll(kNow_ns);
    v1::Packet acknowledgement;
    acknowledgement.set_first(2);
    acknowledgement.set_ack(4);  // SceneInfo, LeaseInfo, RecordInfo, Result
    for (int i = 0; i < clients; ++i) receive(i, 1, acknowledgement);
    datagrams = 0;
  }
  void receive(int client, char counter, const v1::Packet& packet) {
    const auto number = static_cast<std::uint32_t>(client + 1);
    const std::string bytes = datagram_of(number, counter, packet);
    server.receive(ipv4_address({127, 0, 0, 1}, static_cast<std::uint16_t>(40'000 + client)),
                   {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, kNow_ns);
  }

  /// The hand's next pose.
  void move(double y) {
    TickPose pose;
    pose.tick = loop.next_tick();
    pose.pose.p_DH = {0.0, y, 0.0};
    channels->poses.push(pose);
  }
  void tick() { loop.tick_once(0); }
  /// Looks at what the tick has told; false when a part of it is missing.
  bool has_told() {
    LoopEvent event;
    while (channels->events.pop(event)) {
    }
    return channels->ticks.pop(*told) && channels->recorded.pop(*recorded);
  }
  void offer() { server.offer_tick(told->tick, 1, kNow_ns); }
  void record() { recorder.tick(*recorded, &index); }

  ServerHost host() {
    ServerHost host;
    host.greeting = [] { return std::vector<v1::Item>(2); };
    host.request = [](const RequestId&, const v1::Item&) {};
    host.abandoned = [](const RequestId&) {};
    host.fill_state = [this](const Subscription& wanted, v1::State& state) {
      encode_state(*told, index, {wanted.sections, wanted.max_contacts}, state);
    };
    host.lease_lost = [](LeaseEnd) {};
    return host;
  }

  std::shared_ptr<const LoadedScene> scene = loaded_scene();
  SceneIndex index;
  std::unique_ptr<LoopChannels> channels = std::make_unique<LoopChannels>();
  HapticLoop loop{{.virtual_time = true, .snapshots = false}, played(scene), *channels};
  std::uint64_t datagrams = 0;
  std::unique_ptr<Tick> told = std::make_unique<Tick>();
  std::unique_ptr<Tick> recorded = std::make_unique<Tick>();
  ProtocolServer server{{.boot_id = 3},
                        host(),
                        [this](const Address&, std::span<const std::uint8_t>) { ++datagrams; }};
  std::string file = std::filesystem::temp_directory_path() /
                     ("telling_instructions_" + std::to_string(getpid()) + ".mcap");
  Recorder recorder;
};

}  // namespace

// Callgrind collects between the entry and the return of one of these.
[[gnu::noinline]] void haptic_part(Telling& telling) { telling.tick(); }
[[gnu::noinline]] void network_part(Telling& telling) { telling.offer(); }
[[gnu::noinline]] void recorder_part(Telling& telling) { telling.record(); }

namespace {

/// One tick; false when the finger does not press the string after it.
bool pass(const Case& c, Telling& telling, int tick) {
  const bool counted = tick >= kEngaging;
  // From its home down to 2 mm into the string, 0.5 mm up and down there.
  const double low = 5e-3 - 2e-3 + 0.5e-3 * sin_cos(2.0 * kPi * tick / 250.0).sin;
  telling.move(counted ? low : 0.01534);
  counted ? haptic_part(telling) : telling.tick();
  if (!telling.has_told()) return false;
  const bool pressing = !telling.told->string_forces.empty();
  if (c.clients >= 0) counted ? network_part(telling) : telling.offer();
  if (c.recorder) counted ? recorder_part(telling) : telling.record();
  return pressing;
}

int play(const Case& c) {
  Telling telling(c);
  int pressed = 0;
  for (int tick = 0; tick < kEngaging + kTicks; ++tick) pressed += pass(c, telling, tick) ? 1 : 0;
  // What the case is named after must have happened.
  const int datagrams = std::max(c.clients, 0) * (kEngaging + kTicks);
  const bool sent = telling.datagrams == static_cast<std::uint64_t>(datagrams);
  const std::string dump = telling.file + ".dump";
  std::string error;
  const bool recorded = telling.recorder.status().recording == c.file &&
                        telling.recorder.dump(dump, error) == c.recorder;
  std::filesystem::remove(dump);
  if (pressed != kTicks || !sent || !recorded) return 1;
  std::printf("%d ticks\n", kTicks);
  return 0;
}

}  // namespace
}  // namespace hapticd::test

int main(int argc, char** argv) {
  using namespace hapticd::test;
  for (const Case& c : kCases) {
    if (argc < 2) std::printf("%s\n", c.name);
    if (argc < 2 || std::strcmp(argv[1], c.name) != 0) continue;
    try {
      if (play(c) == 0) return 0;
      std::fprintf(stderr, "%s: what it is named after does not happen\n", c.name);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", c.name, error.what());
    }
    return 1;
  }
  return argc < 2 ? 0 : 2;
}
