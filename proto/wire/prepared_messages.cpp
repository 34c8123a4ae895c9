// See prepared_messages.h.
#include "proto/wire/prepared_messages.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <set>
#include <vector>

#include "hapticd/v1/config.pb.h"
#include "hapticd/v1/recording.pb.h"
#include "hapticd/v1/stream.pb.h"
#include "proto/wire/request_rule.h"

namespace hapticd::wire {
namespace {

namespace pb = google::protobuf;

void prepare(const pb::EnumDescriptor& type) {
  // All names are found in one table.
  static_cast<void>(type.FindValueByName(type.value(0)->name()));
  static_cast<void>(type.FindValueByNumber(type.value(0)->number()));
}

/// The type alone, without those nested in it.
void prepare(const pb::Descriptor& type) {
  const pb::Message* prototype = pb::MessageFactory::generated_factory()->GetPrototype(&type);
  static_cast<void>(prototype->GetReflection());
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    static_cast<void>(field.message_type());
    static_cast<void>(type.FindFieldByName(field.name()));
    if (field.enum_type() != nullptr) prepare(*field.enum_type());
  }
}

/// The types of a file, without those of the files it imports.
void prepare(const pb::FileDescriptor& file) {
  std::vector<const pb::Descriptor*> types;
  types.reserve(static_cast<std::size_t>(file.message_type_count()));
  for (int i = 0; i < file.message_type_count(); ++i) types.push_back(file.message_type(i));
  for (std::size_t k = 0; k < types.size(); ++k) {
    const pb::Descriptor& type = *types[k];
    prepare(type);
    for (int i = 0; i < type.nested_type_count(); ++i) types.push_back(type.nested_type(i));
  }
  for (int i = 0; i < file.enum_type_count(); ++i) prepare(*file.enum_type(i));
}

/// `files` and all they import.
std::set<const pb::FileDescriptor*> with_imports(std::vector<const pb::FileDescriptor*> files) {
  std::set<const pb::FileDescriptor*> found;
  while (!files.empty()) {
    const pb::FileDescriptor& file = *files.back();
    files.pop_back();
    if (!found.insert(&file).second) continue;
    for (int i = 0; i < file.dependency_count(); ++i) files.push_back(file.dependency(i));
  }
  return found;
}

}  // namespace

void prepare_messages() {
  for (const pb::FileDescriptor* file :
       with_imports({v1::Config::descriptor()->file(), v1::RecordHeader::descriptor()->file(),
                     v1::Item::descriptor()->file()})) {
    prepare(*file);
  }
  static_cast<void>(rule_of(v1::Item::default_instance()));
}

}  // namespace hapticd::wire
