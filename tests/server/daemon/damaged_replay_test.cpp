// Recordings are files, and files are not to be trusted: a number anywhere in one may be any
// number. Truth: the sanitizers, and that the replay ends.
#include <doctest/doctest.h>
#include <google/protobuf/message.h>

#include <array>
#include <limits>
#include <vector>

#include "tests/server/daemon/recorded_session.h"
#include "tests/server/recorder/sample_ticks.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

/// Ticks played behind the damage.
constexpr int kTicksBehind = 40;

double any_real(SplitMix64& random) {
  constexpr std::array kReals{0.0, -1.0, 1e300, -1e300, std::numeric_limits<double>::infinity()};
  return random.chance(0.5) ? kReals[random.below(kReals.size())] : any_double(random);
}

std::int64_t any_integer(SplitMix64& random) {
  constexpr std::array kIntegers{std::int64_t{-1}, std::int64_t{1} << 31, std::int64_t{1} << 32,
                                 std::numeric_limits<std::int64_t>::max(),
                                 std::numeric_limits<std::int64_t>::min()};
  const std::uint64_t choice = random.below(2 * kIntegers.size());
  if (choice < kIntegers.size()) return kIntegers[choice];
  return static_cast<std::int64_t>(random.next() >> random.below(64));
}

void damage_one(Message& message, const FieldDescriptor& field, SplitMix64& random) {
  const Reflection& access = *message.GetReflection();
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return access.SetDouble(&message, &field, any_real(random));
    case FieldDescriptor::CPPTYPE_UINT64:
      return access.SetUInt64(&message, &field, static_cast<std::uint64_t>(any_integer(random)));
    case FieldDescriptor::CPPTYPE_INT64:
      return access.SetInt64(&message, &field, any_integer(random));
    case FieldDescriptor::CPPTYPE_UINT32:
      return access.SetUInt32(&message, &field, static_cast<std::uint32_t>(any_integer(random)));
    case FieldDescriptor::CPPTYPE_ENUM:
      return access.SetEnumValue(&message, &field, static_cast<int>(any_integer(random)));
    default:
      return access.ClearField(&message, &field);
  }
}

void damage_element(Message& message, const FieldDescriptor& field, SplitMix64& random) {
  const Reflection& access = *message.GetReflection();
  const int size = access.FieldSize(message, &field);
  const int place = static_cast<int>(random.below(static_cast<std::uint64_t>(size)));
  if (random.chance(0.05)) return access.RemoveLast(&message, &field);
  if (random.chance(0.05)) return access.SwapElements(&message, &field, place, 0);
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
    access.SetRepeatedDouble(&message, &field, place, any_real(random));
  } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_INT64) {
    access.SetRepeatedInt64(&message, &field, place, any_integer(random));
  }
}

/// Changes one number, chosen anywhere in it, or takes something away.
// NOLINTNEXTLINE(misc-no-recursion): as deep as messages are nested
void damage(Message& message, SplitMix64& random) {
  const Reflection& access = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  access.ListFields(message, &fields);
  if (fields.empty()) return;
  const FieldDescriptor& field = *fields[random.below(fields.size())];
  const bool nested = field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
  if (!nested && field.is_repeated()) return damage_element(message, field, random);
  if (!nested) return damage_one(message, field, random);
  if (!field.is_repeated()) return damage(*access.MutableMessage(&message, &field), random);
  if (random.chance(0.05)) return access.RemoveLast(&message, &field);
  const auto size = static_cast<std::uint64_t>(access.FieldSize(message, &field));
  const int place = static_cast<int>(random.below(size));
  damage(*access.MutableRepeatedMessage(&message, &field, place), random);
}

template <typename Body>
void damage_as(CopiedMessage& message, SplitMix64& random) {
  Body body;
  REQUIRE(body.ParseFromString(message.bytes));
  damage(body, random);
  message.bytes = body.SerializeAsString();
}

/// Scene, Snapshot and the messages behind it of one place in a recording.
struct Part {
  std::vector<CopiedMessage> messages;
};

std::vector<Part> parts_of(const std::vector<CopiedMessage>& all) {
  std::vector<Part> parts;
  CopiedMessage scene;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (all[k].kind == RecordKind::kScene) scene = all[k];
    if (all[k].kind != RecordKind::kSnapshot) continue;
    Part& part = parts.emplace_back();
    part.messages = {scene, all[k]};
    int ticks = 0;
    for (std::size_t next = k + 1; next < all.size() && ticks < kTicksBehind; ++next) {
      part.messages.push_back(all[next]);
      if (all[next].kind == RecordKind::kTick) ++ticks;
    }
  }
  return parts;
}

/// Damages one message: mostly the Snapshot, else a tick or a change behind it.
void damage(Part& part, SplitMix64& random) {
  const std::size_t place = random.chance(0.6) ? 1 : 1 + random.below(part.messages.size() - 1);
  CopiedMessage& message = part.messages[place];
  if (message.kind == RecordKind::kSnapshot) damage_as<v1::Snapshot>(message, random);
  if (message.kind == RecordKind::kTick) damage_as<v1::TickRecord>(message, random);
  if (message.kind == RecordKind::kParameters) damage_as<v1::ParameterRecord>(message, random);
}

}  // namespace

TEST_CASE("a recording with any number changed is refused or replayed, and harms nothing") {
  const TemporaryFolder folder;
  record_session(folder.file("whole.mcap"), true);
  const v1::RecordHeader header = RecordingReader(folder.file("whole.mcap")).header();
  const std::vector<Part> parts = parts_of(messages_of(folder.file("whole.mcap")));
  REQUIRE(parts.size() >= 3);
  SplitMix64 random(11);
  std::int64_t refused = 0;
  std::int64_t played = 0;
  const std::int64_t rounds = scaled(3000);
  for (std::int64_t round = 0; round < rounds; ++round) {
    CAPTURE(round);
    Part part = parts[random.below(parts.size())];
    damage(part, random);
    std::filesystem::remove(folder.file("damaged.mcap"));
    write_recording(folder.file("damaged.mcap"), header, part.messages);
    try {
      verify(folder.file("damaged.mcap"));
      ++played;
    } catch (const RecordingError&) {
      ++refused;
    }
  }
  CHECK(refused + played == rounds);
  if (rounds >= 100) {
    CHECK(refused > 0);
    CHECK(played > 0);
  }
}

}  // namespace hapticd::test
