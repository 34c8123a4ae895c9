// Walks the generated descriptor pool. Not RT.
#include "tests/protocol/schema.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "hapticd/v1/gateway.pb.h"
#include "hapticd/v1/recording.pb.h"

namespace hapticd::test {

namespace pb = google::protobuf;

namespace {

std::string type_of(const pb::FieldDescriptor& field) {
  if (field.type() == pb::FieldDescriptor::TYPE_MESSAGE) return field.message_type()->full_name();
  if (field.type() == pb::FieldDescriptor::TYPE_ENUM) return field.enum_type()->full_name();
  return field.type_name();
}

std::string label_of(const pb::FieldDescriptor& field) {
  if (field.is_repeated()) return field.is_packed() ? "packed" : "repeated";
  if (const pb::OneofDescriptor* oneof = field.real_containing_oneof()) {
    return "oneof:" + oneof->name();
  }
  return field.has_optional_keyword() ? "optional" : "singular";
}

}  // namespace

std::vector<std::string> proto_files() {
  std::vector<std::string> files;
  const std::filesystem::path root = std::filesystem::path(HAPTICD_SOURCE_DIR) / "proto";
  for (const auto& entry : std::filesystem::directory_iterator(root / "hapticd/v1")) {
    if (entry.path().extension() == ".proto") {
      files.push_back(entry.path().lexically_relative(root).string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<const pb::FileDescriptor*> file_descriptors() {
  // Keeps the linker from leaving the generated code out.
  v1::RecordHeader::descriptor();
  v1::PageEvent::descriptor();
  std::vector<const pb::FileDescriptor*> found;
  for (const std::string& name : proto_files()) {
    const pb::FileDescriptor* file = pb::DescriptorPool::generated_pool()->FindFileByName(name);
    if (file == nullptr) {
      throw std::runtime_error(name + " is not compiled in: add it to proto/CMakeLists.txt");
    }
    found.push_back(file);
  }
  return found;
}

std::vector<const pb::Descriptor*> message_descriptors() {
  std::vector<const pb::Descriptor*> found;
  for (const pb::FileDescriptor* file : file_descriptors()) {
    for (int i = 0; i < file->message_type_count(); ++i) found.push_back(file->message_type(i));
  }
  return found;
}

std::vector<const pb::EnumDescriptor*> enum_descriptors() {
  std::vector<const pb::EnumDescriptor*> found;
  for (const pb::FileDescriptor* file : file_descriptors()) {
    for (int i = 0; i < file->enum_type_count(); ++i) found.push_back(file->enum_type(i));
  }
  return found;
}

std::vector<const pb::FieldDescriptor*> fields_of(const pb::Descriptor& message) {
  std::vector<const pb::FieldDescriptor*> fields;
  fields.reserve(static_cast<std::size_t>(message.field_count()));
  for (int i = 0; i < message.field_count(); ++i) fields.push_back(message.field(i));
  std::sort(fields.begin(), fields.end(),
            [](const auto* left, const auto* right) { return left->number() < right->number(); });
  return fields;
}

bool is_number(const pb::FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_INT32:
    case pb::FieldDescriptor::CPPTYPE_INT64:
    case pb::FieldDescriptor::CPPTYPE_UINT32:
    case pb::FieldDescriptor::CPPTYPE_UINT64:
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
    case pb::FieldDescriptor::CPPTYPE_FLOAT:
      return true;
    default:
      return false;
  }
}

std::vector<std::string> schema_lines() {
  std::vector<std::string> lines;
  for (const pb::Descriptor* message : message_descriptors()) {
    lines.push_back(message->full_name() + " message");
    for (const pb::FieldDescriptor* field : fields_of(*message)) {
      lines.push_back(message->full_name() + ' ' + std::to_string(field->number()) + ' ' +
                      label_of(*field) + ' ' + type_of(*field) + ' ' + field->name());
    }
  }
  for (const pb::EnumDescriptor* type : enum_descriptors()) {
    for (int i = 0; i < type->value_count(); ++i) {
      const pb::EnumValueDescriptor& value = *type->value(i);
      lines.push_back(type->full_name() + ' ' + std::to_string(value.number()) + " value " +
                      value.name());
    }
  }
  return lines;
}

}  // namespace hapticd::test
