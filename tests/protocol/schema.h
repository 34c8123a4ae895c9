// The wire schema as the compiled descriptors know it: every message and enum of hapticd.v1, in the
// order of their files and declarations.
#pragma once

#include <google/protobuf/descriptor.h>

#include <string>
#include <vector>

namespace hapticd::test {

/// Files proto/hapticd/v1/*.proto, as "hapticd/v1/pose.proto", sorted. Read from the source tree.
std::vector<std::string> proto_files();

/// Descriptors of those files. Throws std::runtime_error when one is not linked in.
std::vector<const google::protobuf::FileDescriptor*> file_descriptors();

/// All messages of all files.
std::vector<const google::protobuf::Descriptor*> message_descriptors();

/// All enums of all files.
std::vector<const google::protobuf::EnumDescriptor*> enum_descriptors();

/// Fields of `message` in the order of their numbers.
std::vector<const google::protobuf::FieldDescriptor*> fields_of(
    const google::protobuf::Descriptor& message);

/// True for integer and floating-point fields; not for bool, enum, text, bytes and messages.
bool is_number(const google::protobuf::FieldDescriptor& field);

/// The schema in the form of data/schema_v1.txt: one line for each field and enum value, such as
///   hapticd.v1.Tone 4 singular float frequency_hz
///   hapticd.v1.Cause 3 value CAUSE_INPUT_STALE
/// Whatever a released reader relies on is in the line.
std::vector<std::string> schema_lines();

}  // namespace hapticd::test
