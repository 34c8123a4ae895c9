// See schema_set.h.
#include "proto/recording/schema_set.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <set>
#include <utility>

namespace hapticd {
namespace {

using google::protobuf::FileDescriptor;

/// It only adds options, which no message needs to be read; with it would come descriptor.proto.
bool is_about_schemas(const FileDescriptor& file) { return file.extension_count() > 0; }

// NOLINTNEXTLINE(misc-no-recursion): as deep as imports nest, and they are ours.
void add(const FileDescriptor& file, std::set<const FileDescriptor*>& seen,
         google::protobuf::FileDescriptorSet& set) {
  if (!seen.insert(&file).second) return;
  google::protobuf::FileDescriptorProto copy;
  file.CopyTo(&copy);
  copy.clear_dependency();
  for (int i = 0; i < file.dependency_count(); ++i) {
    if (is_about_schemas(*file.dependency(i))) continue;
    copy.add_dependency(file.dependency(i)->name());
    add(*file.dependency(i), seen, set);
  }
  *set.add_file() = std::move(copy);
}

}  // namespace

std::string schema_set(const google::protobuf::Descriptor& type) {
  google::protobuf::FileDescriptorSet set;
  std::set<const FileDescriptor*> seen;
  add(*type.file(), seen, set);
  return set.SerializeAsString();
}

}  // namespace hapticd
