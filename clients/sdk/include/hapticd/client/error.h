// What a session throws when the daemon refuses, or does not answer.
#pragma once

#include <hapticd/v1/answer.pb.h>

#include <stdexcept>
#include <string>

#pragma GCC visibility push(default)
namespace hapticd::client {
inline namespace abi_0 {

/// A request that did not succeed; what() says what is wrong and what to do. It has changed
/// nothing, except where no answer came: then nobody knows, and in Session::run(): ticks before the
/// failure have run.
class Error : public std::runtime_error {
 public:
  /// `code`: RESULT_CODE_UNSPECIFIED stands for no answer. `path`: the field it is about, or empty.
  Error(v1::ResultCode code, std::string path, const std::string& message);
  Error(const Error&) = default;
  Error& operator=(const Error&) = default;
  ~Error() override;

  /// What kind of failure. RESULT_CODE_UNSPECIFIED: the daemon did not answer.
  [[nodiscard]] v1::ResultCode code() const noexcept;
  /// The field of the request, scene or parameter that is wrong; empty where none is.
  [[nodiscard]] const std::string& path() const noexcept;

 private:
  v1::ResultCode code_;
  std::string path_;
};

}  // namespace abi_0
}  // namespace hapticd::client
#pragma GCC visibility pop
