// What a recording says of its types is enough to read them anywhere, and no more.
#include "proto/recording/schema_set.h"

#include <doctest/doctest.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include "hapticd/v1/recording.pb.h"

namespace hapticd::test {
namespace {

TEST_CASE("a recorded type is whole in a pool of its own, without what only speaks about schemas") {
  for (const google::protobuf::Descriptor* type :
       {v1::TickRecord::descriptor(), v1::EventRecord::descriptor()}) {
    google::protobuf::FileDescriptorSet set;
    REQUIRE(set.ParseFromString(schema_set(*type)));
    google::protobuf::DescriptorPool pool;
    for (const google::protobuf::FileDescriptorProto& file : set.file()) {
      CAPTURE(file.name());
      CHECK(pool.BuildFile(file) != nullptr);
      CHECK(file.extension_size() == 0);
      CHECK(file.name().rfind("hapticd/v1/", 0) == 0);
    }
    const google::protobuf::Descriptor* built = pool.FindMessageTypeByName(type->full_name());
    REQUIRE(built != nullptr);
    CHECK(built->field_count() == type->field_count());
  }
}

}  // namespace
}  // namespace hapticd::test
