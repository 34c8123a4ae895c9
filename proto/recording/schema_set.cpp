// See schema_set.h.
#include "proto/recording/schema_set.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <set>

namespace hapticd {
namespace {

using google::protobuf::FileDescriptor;

// NOLINTNEXTLINE(misc-no-recursion): as deep as imports nest, and they are ours.
void add(const FileDescriptor& file, std::set<const FileDescriptor*>& seen,
         google::protobuf::FileDescriptorSet& set) {
  if (!seen.insert(&file).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) add(*file.dependency(i), seen, set);
  file.CopyTo(set.add_file());
}

}  // namespace

std::string schema_set(const google::protobuf::Descriptor& type) {
  google::protobuf::FileDescriptorSet set;
  std::set<const FileDescriptor*> seen;
  add(*type.file(), seen, set);
  return set.SerializeAsString();
}

}  // namespace hapticd
