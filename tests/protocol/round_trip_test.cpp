// Every message type, filled with random values and extremes, keeps each bit through the wire.
// What was put in is written down while it is put in; what comes out is read through reflection.
#include <doctest/doctest.h>
#include <google/protobuf/message.h>
#include <google/protobuf/stubs/logging.h>

#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include "hapticd/v1/stream.pb.h"
#include "tests/protocol/message_walk.h"
#include "tests/protocol/schema.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

namespace pb = google::protobuf;
using Field = pb::FieldDescriptor;

/// Fills messages and keeps what it filled in.
class Filler {
 public:
  explicit Filler(std::uint64_t seed) : random_(seed) {}

  ValueMap values;

  // NOLINTNEXTLINE(misc-no-recursion): messages nest a few levels deep and never contain themselves
  void fill(pb::Message& message, const std::string& path) {
    const pb::Descriptor& type = *message.GetDescriptor();
    for (int k = 0; k < type.field_count(); ++k) {
      const Field& field = *type.field(k);
      if (field.real_containing_oneof() != nullptr) continue;
      if (field.is_repeated()) {
        const std::uint64_t count = random_.below(4);
        for (std::uint64_t i = 0; i < count; ++i) {
          put(message, field, path + field.name() + '[' + std::to_string(i) + ']');
        }
      } else if (!field.has_presence() || random_.chance(0.7)) {
        put(message, field, path + field.name());
      }
    }
    for (int k = 0; k < type.real_oneof_decl_count(); ++k) {
      const pb::OneofDescriptor& oneof = *type.oneof_decl(k);
      const auto count = static_cast<std::uint64_t>(oneof.field_count());
      const std::uint64_t choice = random_.below(count + 1);  // the last leaves it unset
      if (choice == count) continue;
      const Field& field = *oneof.field(static_cast<int>(choice));
      put(message, field, path + field.name());
    }
  }

 private:
  template <class Number>
  Number number() {
    using Limits = std::numeric_limits<Number>;
    switch (random_.below(8)) {
      case 0:
        return Number{0};
      case 1:
        return Number{1};
      case 2:
        return Limits::max();
      case 3:
        return Limits::lowest();
      case 4:
        return Limits::has_infinity ? Limits::infinity() : Limits::min();
      case 5:
        return std::is_floating_point_v<Number> ? -Number{0} : static_cast<Number>(127);
      case 6:
        return Limits::has_denorm == std::denorm_present ? Limits::denorm_min()
                                                         : static_cast<Number>(128);
      default:
        break;
    }
    Number any{};  // any bits: NaN with payload among them
    const std::uint64_t bits = random_.next();
    std::memcpy(&any, &bits, sizeof any);
    return any;
  }

  std::string text(bool utf8) {
    constexpr std::array<std::string_view, 5> kPieces{"a", std::string_view("\0", 1), "\xc3\xa9",
                                                      "\xe5\xae\xae", "\xf0\x9f\x8e\xb8"};
    std::string result;
    for (std::uint64_t n = random_.below(6); n > 0; --n) {
      if (utf8) {
        result += kPieces[random_.below(kPieces.size())];
      } else {
        result += static_cast<char>(random_.next());
      }
    }
    return result;
  }

  int enumerator(const pb::EnumDescriptor& type) {
    if (random_.chance(0.2)) return number<std::int32_t>();  // of a later version
    const auto count = static_cast<std::uint64_t>(type.value_count());
    return type.value(static_cast<int>(random_.below(count)))->number();
  }

  template <class Number>
  using Setter = void (pb::Reflection::*)(pb::Message*, const Field*, Number) const;

  /// `add` for an element of a repeated field, `set` for a singular one.
  template <class Number>
  void put_as(pb::Message& message, const Field& field, const std::string& path, Setter<Number> add,
              Setter<Number> set, Number value) {
    values[path] = text_of(value);
    (message.GetReflection()->*(field.is_repeated() ? add : set))(&message, &field, value);
  }

  // NOLINTNEXTLINE(misc-no-recursion): messages nest a few levels deep and never contain themselves
  void put(pb::Message& message, const Field& field, const std::string& path) {
    using R = pb::Reflection;
    const R& reflection = *message.GetReflection();
    switch (field.cpp_type()) {
      case Field::CPPTYPE_INT32:
        return put_as(message, field, path, &R::AddInt32, &R::SetInt32, number<std::int32_t>());
      case Field::CPPTYPE_INT64:
        return put_as(message, field, path, &R::AddInt64, &R::SetInt64, number<std::int64_t>());
      case Field::CPPTYPE_UINT32:
        return put_as(message, field, path, &R::AddUInt32, &R::SetUInt32, number<std::uint32_t>());
      case Field::CPPTYPE_UINT64:
        return put_as(message, field, path, &R::AddUInt64, &R::SetUInt64, number<std::uint64_t>());
      case Field::CPPTYPE_DOUBLE:
        return put_as(message, field, path, &R::AddDouble, &R::SetDouble, number<double>());
      case Field::CPPTYPE_FLOAT:
        return put_as(message, field, path, &R::AddFloat, &R::SetFloat, number<float>());
      case Field::CPPTYPE_ENUM:
        return put_as(message, field, path, &R::AddEnumValue, &R::SetEnumValue,
                      enumerator(*field.enum_type()));
      case Field::CPPTYPE_BOOL: {
        REQUIRE(!field.is_repeated());
        const bool value = random_.chance(0.5);
        values[path] = value ? "true" : "false";
        return reflection.SetBool(&message, &field, value);
      }
      case Field::CPPTYPE_STRING: {
        const std::string value = text(field.type() == Field::TYPE_STRING);
        values[path] = value;
        return field.is_repeated() ? reflection.AddString(&message, &field, value)
                                   : reflection.SetString(&message, &field, value);
      }
      case Field::CPPTYPE_MESSAGE:
        values[path] = "present";
        return fill(*(field.is_repeated() ? reflection.AddMessage(&message, &field)
                                          : reflection.MutableMessage(&message, &field)),
                    path + '.');
    }
  }

  SplitMix64 random_;
};

/// Full number of random messages of each type.
constexpr std::int64_t kTrials = 2000;

TEST_CASE("every message keeps every bit of random and extreme values through the wire") {
  for (const pb::Descriptor* type : message_descriptors()) {
    const pb::Message& prototype = *pb::MessageFactory::generated_factory()->GetPrototype(type);
    for (std::int64_t trial = 0; trial < scaled(kTrials); ++trial) {
      CAPTURE(type->full_name());
      CAPTURE(trial);
      const std::unique_ptr<pb::Message> sent(prototype.New());
      Filler filler(static_cast<std::uint64_t>(trial));
      filler.fill(*sent, "");

      std::string wire;
      REQUIRE(sent->SerializeToString(&wire));
      const std::unique_ptr<pb::Message> received(prototype.New());
      REQUIRE(received->ParseFromString(wire));

      ValueMap values;
      add_values(*received, "", values);
      REQUIRE(values == filler.values);
      REQUIRE(received->SerializeAsString() == wire);
    }
  }
}

TEST_CASE("a Packet cut anywhere is refused or loses whole fields, and never crashes") {
  const pb::LogSilencer silence;  // protobuf prints a line for every text cut inside a character
  const std::int64_t trials = scaled(kTrials);
  for (std::int64_t trial = 0; trial < trials; ++trial) {
    v1::Packet packet;
    Filler filler(static_cast<std::uint64_t>(trial));
    filler.fill(packet, "");
    const std::string wire = packet.SerializeAsString();
    for (std::size_t length = 0; length < wire.size(); length += 1 + wire.size() / 64) {
      v1::Packet cut;
      if (cut.ParseFromString(wire.substr(0, length))) CHECK(cut.ByteSizeLong() <= length);
    }
  }
}

TEST_CASE("fields and Items of a later version are skipped, and the rest is read") {
  v1::Packet packet;
  packet.set_ack(7);
  packet.set_first(3);
  packet.add_items()->mutable_ping();
  std::string wire = packet.SerializeAsString();
  wire += "\x1a\x04\xfa\x06\x01x";  // items: field 111, one byte "x"
  wire += "\xf8\x06\x05";           // field 111 of Packet, varint 5

  v1::Packet read;
  REQUIRE(read.ParseFromString(wire));
  CHECK(read.ack() == 7);
  CHECK(read.first() == 3);
  REQUIRE(read.items_size() == 2);
  CHECK(read.items(0).body_case() == v1::Item::kPing);
  CHECK(read.items(1).body_case() == v1::Item::BODY_NOT_SET);
}

}  // namespace
}  // namespace hapticd::test
