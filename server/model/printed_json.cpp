// See printed_json.h.
#include "server/model/printed_json.h"

#include <cstdio>

namespace hapticd {

void print_json(const Json& json) {
  std::printf("%s\n", json.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
}

}  // namespace hapticd
