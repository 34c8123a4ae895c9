// How much fits into a datagram of 1200 bytes: header 16, Packet, tag 16. Sizes come from the
// values a real session has: strings of a Guqin, 1 h of uptime, a hand pressed on two strings and
// the body.
#include <doctest/doctest.h>

#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>

#include "hapticd/v1/stream.pb.h"
#include "tests/support/random.h"

namespace hapticd::v1 {
namespace {

constexpr std::size_t kDatagramBytes = 1200;
constexpr std::size_t kHeaderBytes = 16;
constexpr std::size_t kTagBytes = 16;
/// One hour after boot.
constexpr std::uint64_t kNowNanoseconds = 3'600'123'456'789;

/// A Packet and the seeded values it is filled with.
struct RealisticPacket {
  Packet packet;
  test::SplitMix64 random{20};

  /// A server's Packet an hour into a session at 1 kHz, without items and sections.
  RealisticPacket() {
    packet.set_ack(1234);
    packet.set_first(56789);
    packet.set_boot_id(0xc0ffee11);
    packet.mutable_clock()->set_echoed_ns(kNowNanoseconds);
    packet.mutable_clock()->set_received_ns(kNowNanoseconds);
    packet.mutable_clock()->set_sent_ns(kNowNanoseconds);
    State& state = *packet.mutable_state();
    state.set_tick(3'600'000);
    state.set_t_ns(kNowNanoseconds);
    state.set_loop_state(LOOP_STATE_ENGAGED);
    state.set_scene_id(2);
  }

  double random_position() { return random.uniform(-0.7, 0.7); }
  float random_share() { return static_cast<float>(random.uniform(0.1, 0.9)); }

  void add_tool(std::uint32_t tool_id) {
    ToolState& tool = *packet.mutable_state()->add_tools();
    tool.set_tool_id(tool_id);
    for (int i = 0; i < 3; ++i) {
      tool.add_p_wh_m(random_position());
      tool.add_p_wg_m(random_position());
    }
    for (int i = 0; i < 4; ++i) {
      tool.add_q_wh(random_share());
      tool.add_q_wg(random_share());
    }
    for (int i = 0; i < 6; ++i) tool.add_wrench_h_w(random_share());
    tool.set_minimum_gap_m(2e-5F);
  }

  void add_string(std::uint32_t index, StringPhase phase) {
    StringState& string = *packet.mutable_state()->add_strings();
    string.set_string_index(index);
    string.set_phase(phase);
    if (phase == STRING_PHASE_PRESSED) {
      for (int i = 0; i < 3; ++i) string.add_deflection_w_m(random_share());
    }
    string.set_lambda(random_share());
    string.set_radius_m(random_share());
  }

  ContactPatch& add_patch(std::uint32_t tool_id) {
    ContactPatch& patch = *packet.mutable_state()->add_contacts();
    patch.set_tool_id(tool_id);
    for (int i = 0; i < 3; ++i) patch.add_force_w_n(random_share());
    return patch;
  }

  /// A contact of about 1 N, 20 um above the surface.
  void add_contact(ContactPatch& patch) {
    patch.add_tool_sphere(static_cast<std::int32_t>(64 + random.below(1000)));
    for (int i = 0; i < 3; ++i) {
      patch.add_p_wc_um(static_cast<std::int64_t>(1e6 * random_position()));
      patch.add_nhat_og_w_e4(static_cast<std::int32_t>(1e4 * random.uniform(-1.0, 1.0)));
    }
    patch.add_gap_nanometres(static_cast<std::int32_t>(random.uniform(1e4, 5e4)));
    patch.add_force_mn(static_cast<std::uint32_t>(random.uniform(200.0, 3000.0)));
  }

  void add_contact_event(ContactPhase phase) {
    Contact& contact = *packet.add_items()->mutable_contact();
    contact.set_t_ns(kNowNanoseconds);
    contact.set_phase(phase);
    contact.set_part_index(3);
    contact.set_string_index(4);
    contact.set_lambda(random_share());
    for (int i = 0; i < 3; ++i) {
      contact.add_p_wc_m(random_share());
      contact.add_nhat_og_w(random_share());
    }
    contact.set_normal_speed_m_per_s(random_share());
    contact.set_tangential_speed_m_per_s(random_share());
    contact.set_force_n(random_share());
  }

  void add_tone(std::uint32_t string_index) {
    Tone& tone = *packet.add_items()->mutable_tone();
    tone.set_t_ns(kNowNanoseconds);
    tone.set_string_index(string_index);
    tone.set_frequency_hz(98.0F);
    tone.set_amplitude_m(random_share());
    tone.set_level(random_share());
    tone.set_lambda(random_share());
    tone.set_decay_s(0.5F);
    tone.set_normal_speed_m_per_s(random_share());
    tone.set_tangential_speed_m_per_s(random_share());
    tone.set_glide_cents(random_share());
    tone.set_glide_decay_s(0.25F);
  }

  void add_radius(StringRadiusPhase phase) {
    StringRadius& radius = *packet.add_items()->mutable_string_radius();
    radius.set_t_ns(kNowNanoseconds);
    radius.set_string_index(4);
    radius.set_phase(phase);
    if (phase == STRING_RADIUS_PHASE_PRESS) {
      radius.set_delta_m(random_share());
    } else {
      radius.set_r_max_m(random_share());
      radius.set_decay_s(0.5F);
      radius.set_frequency_hz(98.0F);
    }
  }

  /// Two strings plucked within a round trip: eight events of every kind.
  void add_eight_events() {
    add_contact_event(CONTACT_PHASE_BEGIN);
    add_radius(STRING_RADIUS_PHASE_PRESS);
    add_contact_event(CONTACT_PHASE_END);
    add_radius(STRING_RADIUS_PHASE_RELEASE);
    add_tone(4);
    add_contact_event(CONTACT_PHASE_BEGIN);
    add_radius(STRING_RADIUS_PHASE_PRESS);
    add_tone(5);
  }
};

/// True when proto/PROTOCOL.md states the number that was measured.
bool documented(std::size_t bytes) {
  std::ifstream file(HAPTICD_SOURCE_DIR "/proto/PROTOCOL.md");
  std::stringstream text;
  text << file.rdbuf();
  return text.str().find(' ' + std::to_string(bytes)) != std::string::npos;
}

std::size_t datagram_bytes(const Packet& packet) {
  return kHeaderBytes + packet.ByteSizeLong() + kTagBytes;
}

TEST_CASE("sixteen contacts and eight events fit into one datagram with the default sections") {
  RealisticPacket server;
  server.add_eight_events();
  server.add_tool(0);
  server.add_string(4, STRING_PHASE_PRESSED);
  server.add_string(5, STRING_PHASE_RINGING);
  server.add_string(6, STRING_PHASE_RINGING);
  ContactPatch& string_patch = server.add_patch(0);
  string_patch.set_string_index(4);
  for (int i = 0; i < 4; ++i) server.add_contact(string_patch);
  ContactPatch& body_patch = server.add_patch(0);
  body_patch.set_body_index(0);
  for (int i = 0; i < 12; ++i) server.add_contact(body_patch);
  const Packet& packet = server.packet;
  REQUIRE(packet.items_size() == 8);

  MESSAGE("16 contacts and 8 events: " << datagram_bytes(packet) << " bytes");
  CHECK(documented(datagram_bytes(packet)));
  CHECK(datagram_bytes(packet) <= kDatagramBytes);
}

TEST_CASE("five fingers on seven strings fit into one datagram with the default sections") {
  RealisticPacket server;
  for (std::uint32_t tool_id = 0; tool_id < 5; ++tool_id) {
    server.add_tool(tool_id);
    ContactPatch& patch = server.add_patch(tool_id);
    patch.set_string_index(tool_id);
    server.add_contact(patch);
  }
  for (std::uint32_t index = 0; index < 7; ++index) {
    server.add_string(index, index < 5 ? STRING_PHASE_PRESSED : STRING_PHASE_RINGING);
  }

  const Packet& packet = server.packet;
  MESSAGE("5 tools, 5 contacts, 7 strings: " << datagram_bytes(packet) << " bytes");
  CHECK(documented(datagram_bytes(packet)));
  CHECK(datagram_bytes(packet) <= kDatagramBytes);
}

TEST_CASE("sixteen poses of the scripted device fit into one datagram") {
  Packet packet;
  packet.set_ack(~0ULL);
  packet.set_first(~0ULL);
  packet.set_seen(~0ULL);
  packet.set_newest(~0ULL);
  test::SplitMix64 random(21);
  PoseBatch& batch = *packet.add_items()->mutable_pose_batch();
  batch.set_first_tick(~0ULL);
  for (std::uint32_t k = 0; k < 16; ++k) {
    PoseSample& sample = *batch.add_poses();
    sample.set_tool_id(k);
    for (int i = 0; i < 3; ++i) sample.mutable_pose_dh()->add_p_m(random.uniform());
    for (int i = 0; i < 4; ++i) sample.mutable_pose_dh()->add_q(random.uniform());
  }
  MESSAGE("16 poses: " << datagram_bytes(packet) << " bytes");
  CHECK(documented(datagram_bytes(packet)));
  CHECK(datagram_bytes(packet) <= kDatagramBytes);
}

TEST_CASE("the largest Chunk fits into one datagram whatever else its Packet says") {
  Packet packet;
  packet.set_ack(~0ULL);
  packet.set_first(~0ULL);
  packet.set_seen(~0ULL);
  packet.set_newest(~0ULL);
  packet.set_boot_id(~0U);
  packet.mutable_clock()->set_echoed_ns(~0ULL);
  packet.mutable_clock()->set_received_ns(~0ULL);
  packet.mutable_clock()->set_sent_ns(~0ULL);
  Chunk& chunk = *packet.add_items()->mutable_chunk();
  chunk.set_blob(~0U);
  chunk.set_kind(CHUNK_KIND_ITEM);
  chunk.set_offset(4U << 20U);
  chunk.set_total(4U << 20U);
  chunk.set_bytes(std::string(900, 'x'));
  MESSAGE("one Chunk: " << datagram_bytes(packet) << " bytes");
  CHECK(datagram_bytes(packet) <= kDatagramBytes);
}

TEST_CASE("a contact more costs a State at most 30 bytes within a metre of the origin") {
  RealisticPacket server;
  ContactPatch& patch = server.add_patch(0);
  patch.set_body_index(0);
  for (int i = 0; i < 8; ++i) server.add_contact(patch);
  for (int i = 0; i < 100; ++i) {
    const std::size_t before = server.packet.state().ByteSizeLong();
    server.add_contact(patch);
    CHECK(server.packet.state().ByteSizeLong() - before <= 30);
  }
}

}  // namespace
}  // namespace hapticd::v1
