// What the bridge sends, received by liblo's own server over a real socket of loopback, against the
// namespace of clients/osc/README.md; and its times against hand-made clocks.
#include "clients/osc/bridge.h"

#include <doctest/doctest.h>
#include <lo/lo.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "clients/osc/osc_sender.h"

namespace hapticd::test {
namespace {

using osc::Clocks;
using osc::TimeTag;

/// A message as another program gets it.
struct Heard {
  std::string path;
  std::string types;
  std::vector<double> numbers;  ///< i and f; a text leaves 0
  std::vector<std::string> texts;
  TimeTag when;
};

/// Somebody who listens.
class Listener {
 public:
  Listener() : server_(lo_server_new(nullptr, nullptr)) {
    REQUIRE(server_ != nullptr);
    // What comes early is looked at, not kept for later.
    lo_server_enable_queue(server_, 0, 1);
    lo_server_add_method(server_, nullptr, nullptr, take, this);
  }
  ~Listener() { lo_server_free(server_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  [[nodiscard]] std::uint16_t port() const {
    return static_cast<std::uint16_t>(lo_server_get_port(server_));
  }
  /// Waits for the next one.
  Heard next() {
    for (int i = 0; i < 200 && heard_.empty(); ++i) lo_server_recv_noblock(server_, 100);
    REQUIRE(!heard_.empty());
    Heard first = heard_.front();
    heard_.erase(heard_.begin());
    return first;
  }

 private:
  static int take(const char* path, const char* types, lo_arg** values, int count, lo_message from,
                  void* self) {
    Heard heard{path, types, {}, {}, {}};
    for (int i = 0; i < count; ++i) {
      // liblo points into the message, where 4 bytes are all the alignment there is.
      const void* const raw = values[i];
      const bool is_text = types[i] == 's';
      heard.texts.push_back(is_text ? static_cast<const char*>(raw) : "");
      std::int32_t whole = 0;
      float real = 0.0F;
      if (types[i] == 'i') std::memcpy(&whole, raw, sizeof whole);
      if (types[i] == 'f') std::memcpy(&real, raw, sizeof real);
      heard.numbers.push_back(whole + static_cast<double>(real));
    }
    const lo_timetag when = lo_message_get_timestamp(from);
    heard.when = {when.sec, when.frac};
    static_cast<Listener*>(self)->heard_.push_back(heard);
    return 0;
  }

  lo_server server_;
  std::vector<Heard> heard_;
};

v1::Item tone_item() {
  v1::Item item;
  v1::Tone& tone = *item.mutable_tone();
  tone.set_t_ns(5'000'000'000);
  tone.set_string_index(3);
  tone.set_tool_id(1);
  tone.set_frequency_hz(98.0F);
  tone.set_level(0.75F);
  tone.set_amplitude_m(0.00390625F);
  tone.set_lambda(0.25F);
  tone.set_decay_s(0.5F);
  tone.set_glide_cents(12.0F);
  tone.set_glide_decay_s(0.125F);
  return item;
}

/// The daemon began 100 s after this machine; the time of day is the first second of 2000.
Clocks clocks_at(std::int64_t daemon_ns) {
  Clocks clocks;
  clocks.monotonic_ns = daemon_ns + 100'000'000'000;
  clocks.unix_ns = 946'684'800'000'000'000;
  clocks.daemon_minus_ns = -100'000'000'000;
  return clocks;
}

TEST_CASE("a tone arrives with its nine numbers, at the time it shall be heard") {
  Listener listener;
  osc::OscSender sender("127.0.0.1", listener.port());
  osc::Bridge bridge(
      8'000'000, [&](const auto& message, const auto& when) { return sender.send(message, when); });
  bridge.item(tone_item(), clocks_at(5'003'000'000));
  const Heard heard = listener.next();
  CHECK(heard.path == "/haptic/tone");
  CHECK(heard.types == "iifffffff");
  CHECK(heard.numbers == std::vector<double>{3, 1, 98, 0.75, 0.00390625, 0.25, 0.5, 12, 0.125});
  // 5 ms of the 8 are left. 2000 began 3 155 673 600 s after 1900; a second has 2^32 parts.
  CHECK(heard.when.seconds == 3'155'673'600U);
  CHECK(static_cast<double>(heard.when.fraction) / 4294967296.0 == doctest::Approx(0.005));
  CHECK(bridge.counters().sent == 1);
  CHECK(bridge.counters().late == 0);
}

TEST_CASE("what comes after its time is sent at once and counted") {
  std::vector<TimeTag> tags;
  osc::Bridge bridge(8'000'000, [&](const auto&, const auto& when) {
    tags.push_back(when);
    return true;
  });
  bridge.item(tone_item(), clocks_at(5'009'000'000));
  CHECK(tags == std::vector<TimeTag>{osc::kImmediately});
  CHECK(bridge.counters().late == 1);
}

TEST_CASE("without a delay, or where the clock is not known, everything is sent at once") {
  std::vector<TimeTag> tags;
  const auto note = [&](const auto&, const auto& when) {
    tags.push_back(when);
    return true;
  };
  osc::Bridge at_once(0, note);
  at_once.item(tone_item(), clocks_at(5'000'000'000));
  osc::Bridge later(8'000'000, note);
  Clocks unknown = clocks_at(5'000'000'000);
  unknown.daemon_minus_ns.reset();
  later.item(tone_item(), unknown);
  CHECK(tags == std::vector<TimeTag>{osc::kImmediately, osc::kImmediately});
  CHECK(later.counters().late == 0);
}

TEST_CASE("the time of day becomes OSC's to a quarter of a nanosecond") {
  CHECK(osc::tag_of(0) == TimeTag{2'208'988'800U, 0});
  CHECK(osc::tag_of(500'000'000) == TimeTag{2'208'988'800U, 1U << 31U});
  CHECK(osc::tag_of(1'000'000'000) == TimeTag{2'208'988'801U, 0});
}

TEST_CASE("contacts, strings, poses and scenes arrive as the namespace says") {
  Listener listener;
  osc::OscSender sender("127.0.0.1", listener.port());
  osc::Bridge bridge(
      0, [&](const auto& message, const auto& when) { return sender.send(message, when); });
  v1::Item contact;
  contact.mutable_contact()->set_phase(v1::CONTACT_PHASE_BEGIN);
  contact.mutable_contact()->set_string_index(6);
  contact.mutable_contact()->set_lambda(0.5F);
  for (const float p : {1.0F, 2.0F, 3.0F}) contact.mutable_contact()->add_p_wc_m(p);
  contact.mutable_contact()->set_force_n(0.25F);
  contact.mutable_contact()->set_normal_speed_m_per_s(1.5F);
  contact.mutable_contact()->set_tangential_speed_m_per_s(0.5F);
  bridge.item(contact, {});
  Heard heard = listener.next();
  CHECK(heard.path == "/haptic/contact");
  CHECK(heard.types ==
        "iisiffffff"
        "f");
  CHECK(heard.texts[2] == "string");
  CHECK(heard.numbers == std::vector<double>{1, 0, 0, 6, 0.5, 1, 2, 3, 0.25, 1.5, 0.5});
  contact.mutable_contact()->set_phase(v1::CONTACT_PHASE_END);
  contact.mutable_contact()->set_body_index(2);
  bridge.item(contact, {});
  heard = listener.next();
  CHECK(heard.numbers[0] == 0);
  CHECK(heard.texts[2] == "body");
  CHECK(heard.numbers[3] == 2);

  v1::Item radius;
  radius.mutable_string_radius()->set_string_index(4);
  radius.mutable_string_radius()->set_phase(v1::STRING_RADIUS_PHASE_RELEASE);
  radius.mutable_string_radius()->set_r_max_m(0.5F);
  radius.mutable_string_radius()->set_decay_s(0.25F);
  radius.mutable_string_radius()->set_frequency_hz(65.0F);
  bridge.item(radius, {});
  heard = listener.next();
  CHECK(heard.path == "/haptic/string");
  CHECK(heard.types == "isffff");
  CHECK(heard.texts[1] == "release");
  CHECK(heard.numbers == std::vector<double>{4, 0, 0, 0.5, 0.25, 65});

  v1::State state;
  v1::ToolState& tool = *state.add_tools();
  tool.set_tool_id(2);
  for (const double p : {0.5, 0.25, -0.5}) tool.add_p_wg_m(p);
  for (const float q : {1.0F, 0.0F, 0.0F, 0.0F}) tool.add_q_wg(q);
  for (const float f : {0.0F, 2.0F, -1.0F, 9.0F, 9.0F, 9.0F}) tool.add_wrench_h_w(f);
  bridge.state(state, {});
  heard = listener.next();
  CHECK(heard.path == "/haptic/pose");
  CHECK(heard.types == "iffffffffff");
  CHECK(heard.numbers == std::vector<double>{2, 0.5, 0.25, -0.5, 1, 0, 0, 0, 0, 2, -1});

  v1::Item scene;
  scene.mutable_scene_info()->mutable_scene()->set_name("guqin");
  for (const double f : {65.0, 73.0}) {
    scene.mutable_scene_info()->mutable_scene()->add_strings()->set_frequency_hz(f);
  }
  bridge.item(scene, {});
  heard = listener.next();
  CHECK(heard.path == "/haptic/scene");
  CHECK(heard.types == "siff");
  CHECK(heard.texts[0] == "guqin");
  CHECK(heard.numbers == std::vector<double>{0, 2, 65, 73});
}

TEST_CASE("Items that are no events are not sent") {
  osc::Bridge bridge(0, [](const auto&, const auto&) { return true; });
  v1::Item lease;
  lease.mutable_lease_info();
  bridge.item(lease, {});
  CHECK(bridge.counters().sent == 0);
}

}  // namespace
}  // namespace hapticd::test
