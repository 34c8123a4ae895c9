// The answer to a request: a code, the field it is about, and what to do, for people. Not RT.
#pragma once

#include <string>

#include "hapticd/v1/answer.pb.h"
#include "proto/wire/shown_text.h"

namespace hapticd::wire {

/// A Result with path and message as long as they may be, and text whatever they are: both may
/// quote the request, and no terminal obeys them.
[[nodiscard]] inline v1::Result result_of(v1::ResultCode code, const std::string& path = "",
                                          const std::string& message = "") {
  v1::Result result;
  result.set_code(code);
  result.set_path(whole_characters(shown_text(path), kPathBytes));
  result.set_message(whole_characters(shown_lines(message), kMessageBytes));
  return result;
}

/// The Result of a request that there was no memory for.
[[nodiscard]] inline v1::Result out_of_memory() {
  return result_of(v1::RESULT_CODE_FAILED, "", "There is not enough memory for that now.");
}

}  // namespace hapticd::wire
