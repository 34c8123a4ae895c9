// A Run of steps that makes more events than a road carries: virtual time waits for its session,
// and for others as long as they acknowledge. Real server, real clients, virtual clock, seeded
// loss. PROTOCOL.md, section 11.
#include <doctest/doctest.h>

#include "tests/clients/library/virtual_network.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

const ServerOptions kVirtualClock{.boot_id = 7, .virtual_clock = true};

/// A host that runs steps as the daemon does, with a random number of Tones in each.
class Stepped {
 public:
  Stepped(VirtualNetwork& network, std::uint64_t seed, std::uint64_t most_events)
      : network_(network), random_(seed), most_events_(most_events) {
    network_.host.answers = false;
  }

  /// `from` takes the lease, subscribes and runs `steps`.
  void begin(VirtualClient& from, std::uint64_t steps, std::uint32_t divisor) {
    left_ = steps;
    v1::Item acquire;
    acquire.mutable_acquire()->set_holder("script");
    from.core->request(acquire);
    v1::Item subscribe;
    subscribe.mutable_subscribe()->set_divisor(divisor);
    from.core->request(subscribe);
    v1::Item run;
    run.mutable_run()->set_mode(v1::RUN_MODE_STEP);
    run.mutable_run()->set_steps(steps);
    from.core->request(run, [this](const v1::Result* result) { answered_ = result != nullptr; });
  }

  /// What the daemon does between two looks at the socket.
  void work() {
    if (network_.host.asked.empty()) return;
    for (int k = 0; k < 16 && left_ > 0; ++k) {
      if (!network_.server->may_step(network_.now_ns)) return;
      for (std::uint64_t n = random_.below(most_events_ + 1); n > 0; --n) {
        network_.server->broadcast(tone_item(told_++));
      }
      network_.server->offer_tick(tick_++, 1, network_.now_ns);
      if (--left_ > 0) continue;
      network_.server->answer(network_.host.asked.front().id, result_with());
    }
  }

  /// Runs until the Run is answered and `client` has every Tone; whether that came.
  bool finish(const VirtualClient& client, std::int64_t within_ns) {
    return network_.run_until(within_ns, [&] {
      work();
      return answered_ && client.tones().size() >= told_;
    });
  }

  [[nodiscard]] std::uint32_t told() const { return told_; }
  [[nodiscard]] bool answered() const { return answered_; }

 private:
  VirtualNetwork& network_;
  SplitMix64 random_;
  std::uint64_t most_events_;
  std::uint64_t left_ = 0;
  std::uint64_t tick_ = 0;
  std::uint32_t told_ = 0;
  bool answered_ = false;
};

LinkConditions delayed(std::int64_t delay_ms) {
  LinkConditions conditions;
  conditions.delay_ns = delay_ms * kTestMillisecond_ns;
  return conditions;
}

bool joined(VirtualNetwork& network, const VirtualClient& client) {
  return network.run_until(8 * kTestSecond_ns, [&] { return client.core->heard(); });
}

}  // namespace

TEST_CASE("a Run of steps waits for the Items of its session, whatever the network does") {
  const std::int64_t schedules = scaled(300);
  SplitMix64 random(20261126);
  for (std::int64_t schedule = 0; schedule < schedules; ++schedule) {
    CAPTURE(schedule);
    VirtualNetwork network(kVirtualClock);
    VirtualClient& script = network.add_client(bad_conditions(random), random.next());
    REQUIRE(joined(network, script));
    // The most that a tick brings: 64 events of strings and 128 of each of 5 tools.
    const std::uint64_t most = random.chance(0.2) ? 704 : 1 + random.below(40);
    Stepped run(network, random.next(), most);
    run.begin(script, 20 + random.below(most > 100 ? 10 : 100), random.chance(0.5) ? 1 : 0);
    REQUIRE(run.finish(script, 600 * kTestSecond_ns));
    CHECK(network.server->counters().backlogs == 0);
    CHECK(script.ends.empty());
    CHECK(script.tones() == up_to(run.told()));
  }
}

TEST_CASE("a Run waits for a viewer that acknowledges, and not for one that is mute") {
  const auto play = [](bool with_mute) {
    VirtualNetwork network(kVirtualClock);
    VirtualClient& script = network.add_client({}, 1);
    VirtualClient& viewer = network.add_client(delayed(10), 2);
    VirtualClient& mute = network.add_client({}, 3);
    REQUIRE(joined(network, script));
    REQUIRE(joined(network, viewer));
    REQUIRE(joined(network, mute));
    if (with_mute) {
      mute.to_server.set_blackhole(true);
      mute.to_client.set_blackhole(true);
    }
    Stepped run(network, 4, 10);
    run.begin(script, 1000, 1);
    const std::int64_t begin_ns = network.now_ns;
    REQUIRE(run.finish(viewer, 60 * kTestSecond_ns));
    CHECK(run.told() > 4000);
    CHECK(script.tones() == up_to(run.told()));
    CHECK(viewer.tones() == up_to(run.told()));
    CHECK(script.ends.empty());
    CHECK(viewer.ends.empty());
    CHECK(network.server->counters().backlogs == (with_mute ? 1 : 0));
    return network.now_ns - begin_ns;
  };
  const std::int64_t alone_ns = play(false);
  CHECK(play(true) - alone_ns < 300 * kTestMillisecond_ns);
}

TEST_CASE("a Run whose session falls silent ends with that session") {
  VirtualNetwork network(kVirtualClock);
  VirtualClient& script = network.add_client({}, 1);
  REQUIRE(joined(network, script));
  Stepped run(network, 4, 10);
  run.begin(script, 1'000'000, 0);
  network.run_until(kTestSecond_ns, [&] {
    run.work();
    return false;
  });
  REQUIRE(network.host.abandoned.empty());
  script.to_server.set_blackhole(true);
  network.run_until(11 * kTestSecond_ns, [&] {
    run.work();
    return !network.host.abandoned.empty();
  });
  CHECK(network.host.abandoned.size() == 1);
  CHECK(network.server->counters().backlogs == 0);
  CHECK(network.server->counters().silences == 1);
}

}  // namespace hapticd::test
