// A protobuf type with all the files it needs, as MCAP embeds it. Not RT.
#pragma once

#include <string>

namespace google::protobuf {
class Descriptor;
}

namespace hapticd {

/// A serialised FileDescriptorSet of `type`'s file and everything it imports, imports first.
[[nodiscard]] std::string schema_set(const google::protobuf::Descriptor& type);

}  // namespace hapticd
