// The relay against a mosquitto that the test starts, heard by a subscriber of libmosquitto's own.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <mosquitto.h>
#include <netinet/in.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <vector>

#include "clients/relay/broker.h"
#include "clients/relay/relay.h"

namespace hapticd::test {
namespace {

using relay::Publication;

constexpr const char* kMosquitto = "/usr/sbin/mosquitto";
/// Longest wait: far more than it takes, so that only what never comes fails.
constexpr std::chrono::seconds kDeadline{20};

template <typename Done>
bool wait_until(const Done& done) {
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
  }
  return true;
}

std::uint16_t free_port() {
  const int file = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  REQUIRE(::bind(file, generic, length) == 0);
  REQUIRE(::getsockname(file, generic, &length) == 0);
  ::close(file);
  return ntohs(address.sin_port);
}

/// A real broker of its own, on loopback.
class Mosquitto {
 public:
  explicit Mosquitto(std::uint16_t port) {
    std::string name = (std::filesystem::temp_directory_path() / "hapticd_mqtt_XXXXXX").string();
    const int file = ::mkstemp(name.data());
    REQUIRE(file >= 0);
    ::close(file);
    config_ = name;
    std::ofstream(config_) << "listener " << port << " 127.0.0.1\nallow_anonymous true\n"
                           << "persistence false\nlog_type none\n";
    posix_spawn_file_actions_t quiet;
    posix_spawn_file_actions_init(&quiet);
    posix_spawn_file_actions_addopen(&quiet, 2, "/dev/null", O_WRONLY, 0);
    std::string program = kMosquitto;
    std::string option = "-c";
    char* const arguments[] = {program.data(), option.data(), config_.data(), nullptr};
    REQUIRE(::posix_spawn(&process_, kMosquitto, &quiet, nullptr, arguments, environ) == 0);
    posix_spawn_file_actions_destroy(&quiet);
  }
  ~Mosquitto() {
    ::kill(process_, SIGTERM);
    ::waitpid(process_, nullptr, 0);
    std::filesystem::remove(config_);
  }
  Mosquitto(const Mosquitto&) = delete;
  Mosquitto& operator=(const Mosquitto&) = delete;

 private:
  std::string config_;
  pid_t process_ = 0;
};

/// Somebody of the audience: hears all below a prefix.
class Listener {
 public:
  Listener(std::uint16_t port, const std::string& topics) {
    mosquitto_lib_init();
    client_ = mosquitto_new(nullptr, true, this);
    mosquitto_message_callback_set(client_,
                                   [](mosquitto*, void* self, const mosquitto_message* message) {
                                     static_cast<Listener*>(self)->heard[message->topic].push_back(
                                         {message->topic,
                                          {static_cast<const char*>(message->payload),
                                           static_cast<std::size_t>(message->payloadlen)},
                                          message->retain,
                                          message->qos});
                                   });
    REQUIRE(wait_until(
        [&] { return mosquitto_connect(client_, "127.0.0.1", port, 10) == MOSQ_ERR_SUCCESS; }));
    REQUIRE(mosquitto_subscribe(client_, nullptr, topics.c_str(), 1) == MOSQ_ERR_SUCCESS);
  }
  ~Listener() {
    mosquitto_destroy(client_);
    mosquitto_lib_cleanup();
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  bool hears(const std::string& topic, std::size_t count) {
    return wait_until([&] {
      mosquitto_loop(client_, 20, 1);
      return heard[topic].size() >= count;
    });
  }
  std::map<std::string, std::vector<Publication>> heard;

 private:
  mosquitto* client_ = nullptr;
};

v1::Item tone(std::uint32_t string_index) {
  v1::Item item;
  item.mutable_tone()->set_string_index(string_index);
  return item;
}

v1::Item scene(const std::string& name) {
  v1::Item item;
  item.mutable_scene_info()->mutable_scene()->set_name(name);
  return item;
}

TEST_CASE("an audience hears tones in order and whole, who comes late gets the scene at once") {
  const std::uint16_t port = free_port();
  const Mosquitto mosquitto(port);
  relay::BrokerOptions options;
  options.port = port;
  options.will = relay::link_publication("stage/one", false);
  std::optional<relay::Broker> broker(options);
  relay::Relay relay("stage/one", [&](const auto& each) { return broker->publish(each); });
  relay.item(scene("guqin"));  // before the broker is there: kept for it
  REQUIRE(wait_until([&] { return broker->connections() == 1; }));
  relay.connected();
  relay.link(true);
  Listener early(port, "stage/one/#");
  REQUIRE(early.hears("stage/one/scene", 1));
  for (std::uint32_t i = 0; i < 50; ++i) relay.item(tone(i));
  REQUIRE(early.hears("stage/one/tone", 50));
  for (std::uint32_t i = 0; i < 50; ++i) {
    v1::Item heard;
    REQUIRE(heard.ParseFromString(early.heard["stage/one/tone"][i].payload));
    CHECK(heard.tone().string_index() == i);
    CHECK_FALSE(early.heard["stage/one/tone"][i].retained);
  }
  v1::State state;
  state.set_tick(42);
  relay.state(state);
  REQUIRE(early.hears("stage/one/state", 1));
  Listener late(port, "stage/one/#");
  REQUIRE(late.hears("stage/one/scene", 1));
  const Publication& kept = late.heard["stage/one/scene"][0];
  v1::Item heard;
  REQUIRE(heard.ParseFromString(kept.payload));
  CHECK(heard.scene_info().scene().name() == "guqin");
  CHECK(kept.retained);
  REQUIRE(late.hears("stage/one/link", 1));
  CHECK(late.heard["stage/one/link"][0].payload == "live");
  CHECK(late.heard["stage/one/tone"].empty());
}

TEST_CASE("a broker that comes later, or again, gets what it has to keep") {
  const std::uint16_t port = free_port();
  relay::BrokerOptions options;
  options.port = port;
  options.will = relay::link_publication("hapticd", false);
  relay::Broker broker(options);
  relay::Relay relay("hapticd", [&](const auto& each) { return broker.publish(each); });
  relay.item(scene("bunny"));
  CHECK(relay.counters().lost == 1);
  for (std::uint64_t time = 1; time <= 2; ++time) {
    const Mosquitto mosquitto(port);
    REQUIRE(wait_until([&] { return broker.connections() == time; }));
    relay.connected();
    Listener listener(port, "hapticd/scene");
    CHECK(listener.hears("hapticd/scene", 1));
  }
}

}  // namespace
}  // namespace hapticd::test
