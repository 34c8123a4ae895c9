// Texts that hapticctl reads and writes: values of parameters, protobuf messages as JSON or
// from text format, names of enum values for people. Pure, except those that read a file. Not RT.
#pragma once

#include <google/protobuf/message.h>

#include <fstream>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "hapticd/v1/control.pb.h"

namespace hapticd::ctl {

/// One line of JSON with the names of the .proto files, fields that are 0 included.
[[nodiscard]] std::string to_json(const google::protobuf::Message& message);

/// One line of JSON in valid UTF-8: U+FFFD stands for bytes of a path that are none.
[[nodiscard]] std::string to_json(const nlohmann::ordered_json& json);

/// Prints a line. What came from a daemon may be in it: no control reaches the terminal.
void print_text(const std::string& text);

/// The same for text that may have several lines.
void print_lines(const std::string& text);

/// The same on stderr, after the name of the program.
void print_problem(const std::string& text);

/// Prints a line with a name in a column and what it stands for.
void print_row(const std::string& name, const std::string& description);

/// "LOOP_STATE_ENGAGED" without what all values of the enum begin with, in small letters:
/// "engaged".
[[nodiscard]] std::string plain_name(std::string_view name, std::string_view prefix);

/// "path=value", the value a number, true, false, [numbers] or a text; throws Failure(kUsageBad).
[[nodiscard]] v1::Assignment parse_assignment(const std::string& text);

/// "path = value" as parse_assignment reads it.
[[nodiscard]] std::string to_text(const v1::Assignment& assignment);

/// Throws Failure(kUsageBad) that names the first text of `message`, or of a message in it, that is
/// not UTF-8: protobuf sends it all the same, and nobody can read it.
void require_utf8(const google::protobuf::Message& message);

/// A file to read, which is there; throws Failure(kRefused) that says why not.
[[nodiscard]] std::ifstream open_file(const std::string& path);

/// All of a file; throws Failure(kRefused) that says why not.
[[nodiscard]] std::string read_file(const std::string& path);

/// As read_file; throws Failure(kRefused) that names the line where it is not UTF-8.
[[nodiscard]] std::string read_text(const std::string& path);

/// As read_text, of a source that names_file(): who may have meant something installed is told how
/// its names look.
[[nodiscard]] std::string read_source(const std::string& source);

/// True for what names a file rather than something installed: it has a '.' or another character
/// that no installed name has.
[[nodiscard]] bool names_file(const std::string& source);

/// Parses protobuf text format; throws Failure(kRefused) with file and line.
void parse_text(const std::string& text, const std::string& file,
                google::protobuf::Message& message);

}  // namespace hapticd::ctl
