// See request_rule.h.
#include "proto/wire/request_rule.h"

#include <google/protobuf/descriptor.h>

#include <vector>

namespace hapticd::wire {
namespace {

/// By the number of Item's field.
std::vector<const v1::RequestRule*> all_rules() {
  std::vector<const v1::RequestRule*> rules;
  const google::protobuf::Descriptor& item = *v1::Item::descriptor();
  for (int i = 0; i < item.field_count(); ++i) {
    const google::protobuf::FieldDescriptor& field = *item.field(i);
    if (!field.options().HasExtension(v1::request)) continue;
    const auto number = static_cast<std::size_t>(field.number());
    if (rules.size() <= number) rules.resize(number + 1, nullptr);
    rules[number] = &field.options().GetExtension(v1::request);
  }
  return rules;
}

}  // namespace

const v1::RequestRule* rule_of(const v1::Item& item) {
  static const std::vector<const v1::RequestRule*> rules = all_rules();
  const auto number = static_cast<std::size_t>(item.body_case());
  return number < rules.size() ? rules[number] : nullptr;
}

bool needs_lease(const v1::Item& item) {
  const v1::RequestRule* rule = rule_of(item);
  return rule != nullptr && rule->need() == v1::REQUEST_NEED_LEASE;
}

bool needs_control(const v1::Item& item) {
  const v1::RequestRule* rule = rule_of(item);
  return rule != nullptr && rule->need() != v1::REQUEST_NEED_NOTHING;
}

}  // namespace hapticd::wire
