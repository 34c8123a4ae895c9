// Finds enum numbers that this version has no value for: proto3 lets any number through. For what
// comes from a peer or a configuration. Not RT.
#pragma once

#include <google/protobuf/message.h>

#include <optional>
#include <string>

namespace hapticd::wire {

/// A number that is not a value of its enum.
struct UnknownChoice {
  std::string path;     ///< of the field, below the message
  std::string message;  ///< which number, and what there is instead
};

/// The values of `type`, in a sentence.
[[nodiscard]] std::string choices_of(const google::protobuf::EnumDescriptor& type);

/// The first in `message` and in all messages below it; nothing: every number is known. O(fields).
[[nodiscard]] std::optional<UnknownChoice> unknown_choice(const google::protobuf::Message& message);

}  // namespace hapticd::wire
