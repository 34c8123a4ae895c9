// What to write instead, for what the parser of protobuf's text format finds wrong. Not RT.
#pragma once

#include <google/protobuf/descriptor.h>

#include <string>

namespace hapticd::hints {

/// Sentences for an error `message` of google::protobuf::TextFormat::Parser (3.21) on a text that
/// was to be a message of type `root`: the field or the value that was meant, or how it is written.
/// Empty: no better word is known. Cost: all fields of `root` and of the messages below it, once.
[[nodiscard]] std::string text_remedy(const google::protobuf::Descriptor& root,
                                      const std::string& message);

}  // namespace hapticd::hints
