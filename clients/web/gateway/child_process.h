// Another program, spoken to in lines by its standard input and output; what it says on standard
// error goes where ours goes. One socket is both, so that writing to a program that is gone raises
// no signal. Everything happens in the io_context. One thread. Not RT.
#pragma once

#include <sys/types.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace hapticd::web {

/// What comes of it.
struct LineHandlers {
  std::function<void(const std::string& line)> line;
  std::function<void(int exit_code)> ended;  ///< the last word; 128 + signal where one ended it
};

class ChildProcess : public std::enable_shared_from_this<ChildProcess> {
 public:
  ChildProcess(boost::asio::io_context& context, LineHandlers handlers);

  /// Starts words[0], searched in PATH where it has no slash. Throws std::system_error.
  void start(std::vector<std::string> words);
  /// Sends a line; what does not fit into the socket is not sent, and the program is ended.
  void say(std::string_view line);
  /// Ends its input, and ends the program if it does not end by itself then.
  void finish();

 private:
  void read();
  void reap();
  void tell_end();

  LineHandlers handlers_;
  boost::asio::local::stream_protocol::socket socket_;
  boost::asio::posix::stream_descriptor process_;  ///< readable when it has ended
  boost::asio::steady_timer patience_;
  std::string incoming_;
  pid_t pid_ = -1;
};

/// The program `name` beside this one, else its name alone, for PATH.
[[nodiscard]] std::string program_beside(const std::string& name);

}  // namespace hapticd::web
