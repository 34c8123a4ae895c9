// The comments of the .proto files, taken apart. A field's comment says what the field is and ends
// in
//   [unit; shape; range; when absent]
// of which a field has the parts that make sense for it (proto/PROTOCOL.md, "Comments").
#pragma once

#include <google/protobuf/descriptor.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hapticd::test {

struct FieldComment {
  std::string text;                ///< what the field is, without the brackets
  std::vector<std::string> parts;  ///< what is in the brackets; empty when there are none
};

/// The schema with the comments of its sources. Throws std::runtime_error when protoc's output for
/// it is missing.
class CommentedSchema {
 public:
  CommentedSchema();
  ~CommentedSchema();
  CommentedSchema(const CommentedSchema&) = delete;
  CommentedSchema& operator=(const CommentedSchema&) = delete;

  /// Comment above (or behind) a field.
  [[nodiscard]] FieldComment of(const google::protobuf::FieldDescriptor& field) const;
  /// Comment above a oneof.
  [[nodiscard]] FieldComment of(const google::protobuf::OneofDescriptor& oneof) const;
  /// Text above a message.
  [[nodiscard]] std::string of(const google::protobuf::Descriptor& message) const;
  /// Text above an enum.
  [[nodiscard]] std::string of(const google::protobuf::EnumDescriptor& type) const;

 private:
  std::unique_ptr<google::protobuf::DescriptorPool> pool_;
};

/// True for numbers, alone or repeated, and for a Quantity of numbers.
bool holds_numbers(const google::protobuf::FieldDescriptor& field);

/// The first part: the unit of numbers. Empty when there is none.
std::string unit_part(const FieldComment& comment);

/// The part that says what an absent field means.
std::string absence_part(const FieldComment& comment);

/// The range of a field that holds numbers: the part before the last. Empty when there is none.
std::string range_part(const FieldComment& comment);

/// True when `value` is in `range`, an interval "[a, b]" with round brackets for open ends, ">= a",
/// "-1 or 1", "finite" or "any"; nothing when `range` is none of these.
std::optional<bool> in_range(const std::string& range, double value);

}  // namespace hapticd::test
