// The answer to a request: a code, the field it is about, and what to do, for people.
#pragma once

#include <string>

#include "hapticd/v1/answer.pb.h"

namespace hapticd {

/// Longer messages are cut, characters (Result.message).
inline constexpr std::size_t kLongestMessage = 400;

[[nodiscard]] inline v1::Result result_of(v1::ResultCode code, const std::string& path = "",
                                          const std::string& message = "") {
  v1::Result result;
  result.set_code(code);
  result.set_path(path);
  result.set_message(message.substr(0, kLongestMessage));
  return result;
}

}  // namespace hapticd
