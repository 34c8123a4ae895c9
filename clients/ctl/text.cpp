// See text.h.
#include "clients/ctl/text.h"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "clients/ctl/connection.h"
#include "proto/hints/text_remedy.h"
#include "proto/wire/shown_text.h"

namespace hapticd::ctl {
namespace {

namespace pb = google::protobuf;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == ','; }

/// All numbers of `text`, separated by blanks and commas; nothing when it holds anything else.
std::optional<std::vector<double>> numbers_of(std::string_view text) {
  std::vector<double> numbers;
  while (true) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    if (text.empty()) return numbers;
    double number = 0.0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
    text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
    if (read.ec != std::errc{} || (!text.empty() && !is_blank(text.front()))) return std::nullopt;
    numbers.push_back(number);
  }
}

/// The shortest text that reads back as the same number.
std::string in_words(double number) {
  char buffer[32];
  const auto end = std::to_chars(std::begin(buffer), std::end(buffer), number).ptr;
  return {std::begin(buffer), end};
}

/// Bytes of `text` before the first that is not UTF-8; its size where all are.
std::size_t utf8_bytes(const std::string& text) {
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t bytes = wire::character_bytes(text, at);
    if (bytes == 0) break;
    at += bytes;
  }
  return at;
}

/// Keeps the first error of a text.
class FirstError : public pb::io::ErrorCollector {
 public:
  void AddError(int line, pb::io::ColumnNumber column, const std::string& message) override {
    if (!text.empty()) return;
    place = ":" + std::to_string(line + 1) + ":" + std::to_string(column + 1) + ": ";
    text = message;
  }
  std::string place;
  std::string text;
};

}  // namespace

std::string to_json(const pb::Message& message) {
  pb::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string text;
  if (!pb::util::MessageToJsonString(message, &text, options).ok()) return "{}";
  return text;
}

std::string to_json(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void print_text(const std::string& text) { std::printf("%s\n", wire::shown_text(text).c_str()); }

void print_lines(const std::string& text) { std::printf("%s\n", wire::shown_lines(text).c_str()); }

void print_row(const std::string& name, const std::string& description) {
  constexpr std::size_t kColumn = 26;
  std::string line = wire::shown_text(name);
  line.resize(std::max(line.size(), kColumn), ' ');
  print_text(line + wire::shown_text(description));
}

void print_problem(const std::string& text) {
  std::fprintf(stderr, "hapticctl: %s\n", wire::shown_lines(text).c_str());
}

std::string plain_name(std::string_view name, std::string_view prefix) {
  if (name.starts_with(prefix)) name.remove_prefix(prefix.size());
  std::string text(name);
  for (char& c : text) c = c == '_' ? ' ' : static_cast<char>(std::tolower(c));
  return text;
}

v1::Assignment parse_assignment(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == text.size()) {
    throw Failure(kUsageBad, "'" + text + "' is not PATH=VALUE, such as strings[3].tension_n=80");
  }
  v1::Assignment assignment;
  assignment.set_path(text.substr(0, equals));
  const std::string value = text.substr(equals + 1);
  const bool list = value.size() >= 2 && value.front() == '[' && value.back() == ']';
  const auto numbers =
      numbers_of(list ? std::string_view(value).substr(1, value.size() - 2) : value);
  if (list && numbers) {
    for (const double number : *numbers) assignment.mutable_numbers()->add_values(number);
  } else if (numbers && numbers->size() == 1) {
    assignment.set_number(numbers->front());
  } else if (value == "true" || value == "false") {
    assignment.set_flag(value == "true");
  } else {
    assignment.set_text(value);
  }
  return assignment;
}

std::string to_text(const v1::Assignment& assignment) {
  std::string text = assignment.path() + "=";
  switch (assignment.value_case()) {
    case v1::Assignment::kNumber:
      return text + in_words(assignment.number());
    case v1::Assignment::kFlag:
      return text + (assignment.flag() ? "true" : "false");
    case v1::Assignment::kText:
      return text + assignment.text();
    case v1::Assignment::kNumbers:
      break;
    case v1::Assignment::VALUE_NOT_SET:
      return text;
  }
  text += "[";
  for (int i = 0; i < assignment.numbers().values_size(); ++i) {
    text += (i == 0 ? "" : ",") + in_words(assignment.numbers().values(i));
  }
  return text + "]";
}

// NOLINTNEXTLINE(misc-no-recursion): as deep as messages are nested
void require_utf8(const pb::Message& message) {
  const pb::Reflection& r = *message.GetReflection();
  std::vector<const pb::FieldDescriptor*> fields;
  r.ListFields(message, &fields);
  for (const pb::FieldDescriptor* field : fields) {
    const int count = field->is_repeated() ? r.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      if (field->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE) {
        require_utf8(field->is_repeated() ? r.GetRepeatedMessage(message, field, i)
                                          : r.GetMessage(message, field));
      } else if (field->type() == pb::FieldDescriptor::TYPE_STRING) {
        const std::string text = field->is_repeated() ? r.GetRepeatedString(message, field, i)
                                                      : r.GetString(message, field);
        if (utf8_bytes(text) == text.size()) continue;
        throw Failure(kUsageBad, field->name() + ": '" +
                                     wire::whole_characters(text, wire::kPathBytes) +
                                     "' is not text in UTF-8; ? stands for what is none");
      }
    }
  }
}

std::ifstream open_file(const std::string& path) {
  std::error_code unknown;
  if (std::filesystem::is_directory(path, unknown)) {
    throw Failure(kRefused, path + ": is a folder. Name a file.");
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (file) return file;
  if (errno == ENOENT) throw Failure(kRefused, path + ": there is no such file.");
  throw Failure(kRefused,
                path + ": cannot be read: " + std::generic_category().message(errno) + ".");
}

std::string read_file(const std::string& path) {
  std::ifstream file = open_file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string read_text(const std::string& path) {
  std::string text = read_file(path);
  const std::size_t whole = utf8_bytes(text);
  if (whole == text.size()) return text;
  const auto line =
      std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(whole), '\n');
  throw Failure(kRefused, path + ":" + std::to_string(line + 1) + ": is not text in UTF-8");
}

std::string read_source(const std::string& source) {
  try {
    return read_text(source);
  } catch (const Failure& failure) {
    if (source.find_first_of("./") != std::string::npos) throw;
    throw Failure(failure.exit_code(), std::string(failure.what()) +
                                           " What is installed has a name of a-z 0-9 _ - alone.");
  }
}

bool names_file(const std::string& source) {
  return std::any_of(source.begin(), source.end(), [](char c) {
    return !((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-');
  });
}

void parse_text(const std::string& text, const std::string& file, pb::Message& message) {
  FirstError error;
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(&error);
  if (parser.ParseFromString(text, &message)) return;
  std::string fault = file + error.place + error.text;
  if (!fault.ends_with('.')) fault += ".";
  const std::string remedy = hints::text_remedy(*message.GetDescriptor(), error.text);
  throw Failure(kRefused, remedy.empty() ? fault : fault + " " + remedy);
}

}  // namespace hapticd::ctl
