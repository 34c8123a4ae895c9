// Reads the descriptor set that protoc writes with --include_source_info: it keeps the comments,
// which the generated descriptors do not. Not RT.
#include "tests/protocol/field_comment.h"

#include <google/protobuf/descriptor.pb.h>

#include <cmath>
#include <fstream>
#include <regex>
#include <stdexcept>

#include "tests/protocol/schema.h"

namespace hapticd::test {

namespace pb = google::protobuf;

namespace {

std::string one_line(std::string text) {
  text = std::regex_replace(text, std::regex("\\s+"), " ");
  return std::regex_replace(text, std::regex("^ | $"), "");
}

template <class D>
std::string comment_of(const D& descriptor) {
  pb::SourceLocation location;
  if (!descriptor.GetSourceLocation(&location)) return "";
  return one_line(location.leading_comments + ' ' + location.trailing_comments);
}

FieldComment take_apart(const std::string& comment) {
  static const std::regex form(R"((.*[.?]) \[(.*)\])");
  std::smatch match;
  if (!std::regex_match(comment, match, form)) return {comment, {}};
  FieldComment result{match[1], {}};
  const std::string tail = match[2];
  static const std::regex semicolon("; ");
  result.parts.assign(std::sregex_token_iterator(tail.begin(), tail.end(), semicolon, -1), {});
  return result;
}

}  // namespace

CommentedSchema::CommentedSchema() : pool_(std::make_unique<pb::DescriptorPool>()) {
  std::ifstream file(HAPTICD_COMMENTED_SCHEMA, std::ios::binary);
  pb::FileDescriptorSet set;
  if (!set.ParseFromIstream(&file)) throw std::runtime_error("no " HAPTICD_COMMENTED_SCHEMA);
  for (const pb::FileDescriptorProto& each : set.file()) {
    if (pool_->BuildFile(each) == nullptr) throw std::runtime_error(each.name());
  }
}

CommentedSchema::~CommentedSchema() = default;

FieldComment CommentedSchema::of(const pb::FieldDescriptor& field) const {
  return take_apart(comment_of(*pool_->FindFieldByName(field.full_name())));
}

FieldComment CommentedSchema::of(const pb::OneofDescriptor& oneof) const {
  return take_apart(comment_of(*pool_->FindOneofByName(oneof.full_name())));
}

std::string CommentedSchema::of(const pb::Descriptor& message) const {
  return comment_of(*pool_->FindMessageTypeByName(message.full_name()));
}

std::string CommentedSchema::of(const pb::EnumDescriptor& type) const {
  return comment_of(*pool_->FindEnumTypeByName(type.full_name()));
}

bool holds_numbers(const pb::FieldDescriptor& field) {
  return is_number(field) || (field.message_type() != nullptr &&
                              field.message_type()->full_name() == "hapticd.v1.Quantity");
}

std::string unit_part(const FieldComment& comment) {
  return comment.parts.empty() ? "" : comment.parts.front();
}

std::string absence_part(const FieldComment& comment) {
  return comment.parts.empty() ? "" : comment.parts.back();
}

std::string range_part(const FieldComment& comment) {
  return comment.parts.size() < 2 ? "" : comment.parts[comment.parts.size() - 2];
}

std::optional<bool> in_range(const std::string& range, double value) {
  static const std::regex interval(R"(([\[(])([-+.\de]+), ([-+.\de]+)([\])]))");
  static const std::regex at_least(R"(>= ([-+.\de]+))");
  std::smatch match;
  if (range == "any" || range == "any bits") return true;
  if (range == "finite") return std::isfinite(value);
  if (range == "-1 or 1") return value == -1.0 || value == 1.0;
  if (std::regex_match(range, match, at_least)) return value >= std::stod(match[1]);
  if (!std::regex_match(range, match, interval)) return std::nullopt;
  const double low = std::stod(match[2]);
  const double high = std::stod(match[3]);
  const bool above = match[1] == "[" ? value >= low : value > low;
  const bool below = match[4] == "]" ? value <= high : value < high;
  return above && below;
}

}  // namespace hapticd::test
