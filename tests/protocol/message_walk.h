// Walks over all fields of a message through reflection: every value as text, so that two messages
// can be compared without trusting their serialisation; every field that is set.
#pragma once

#include <google/protobuf/message.h>

#include <cstdint>
#include <functional>
#include <map>
#include <string>

namespace hapticd::test {

/// Path such as "state.tools[0].p_wh_m[2]" to value. Numbers are kept bit for bit.
using ValueMap = std::map<std::string, std::string>;

/// Text of a number, of a floating-point number its bits: NaN payloads and -0 differ from their
/// look-alikes.
std::string text_of(double value);
std::string text_of(float value);
std::string text_of(std::int32_t value);
std::string text_of(std::int64_t value);
std::string text_of(std::uint32_t value);
std::string text_of(std::uint64_t value);

/// All values of `message` below `path`: fields without presence always, others when they are set.
/// A message that is set has an entry "present" of its own.
void add_values(const google::protobuf::Message& message, const std::string& path,
                ValueMap& values);

using FieldVisitor =
    std::function<void(const google::protobuf::Message&, const google::protobuf::FieldDescriptor&)>;

/// Calls `visit` with every field that is set, and the message it is set in, at every depth.
void for_each_set_field(const google::protobuf::Message& message, const FieldVisitor& visit);

}  // namespace hapticd::test
