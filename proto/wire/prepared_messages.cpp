// See prepared_messages.h.
#include "proto/wire/prepared_messages.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <set>

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

void prepare(const pb::Descriptor& type) {
  const pb::Message* prototype = pb::MessageFactory::generated_factory()->GetPrototype(&type);
  static_cast<void>(prototype->GetReflection());
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    static_cast<void>(field.message_type());
    static_cast<void>(type.FindFieldByName(field.name()));
    if (field.enum_type() != nullptr) prepare(*field.enum_type());
  }
  for (int i = 0; i < type.nested_type_count(); ++i) prepare(*type.nested_type(i));
}

void prepare(const pb::FileDescriptor& file, std::set<const pb::FileDescriptor*>& done) {
  if (!done.insert(&file).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) prepare(*file.dependency(i), done);
  for (int i = 0; i < file.message_type_count(); ++i) prepare(*file.message_type(i));
  for (int i = 0; i < file.enum_type_count(); ++i) prepare(*file.enum_type(i));
}

}  // namespace

void prepare_messages() {
  std::set<const pb::FileDescriptor*> done;
  prepare(*v1::Config::descriptor()->file(), done);
  prepare(*v1::RecordHeader::descriptor()->file(), done);
  prepare(*v1::Item::descriptor()->file(), done);
  static_cast<void>(rule_of(v1::Item::default_instance()));
}

}  // namespace hapticd::wire
