#include "rollerrig/plant/archive.hpp"

#include <algorithm>
#include <map>

namespace rollerrig::archive {
namespace {

/// Values to bytes, or bytes to values: which of the two is there.
struct Walk {
  ByteWriter* out;
  ByteReader* in;
  // Shared tables that have been met, in the order of their first places; of those read also what each is.
  std::map<void const*, std::uint64_t> written{};
  std::vector<std::pair<Type const*, std::shared_ptr<void const>>> read{};

  void operator()(Type const& type, void* value) {
    switch (type.kind) {
      case Type::number: return numbers(value, type.size);
      case Type::flag: return out ? out->flag(as<bool>(value)) : void(as<bool>(value) = in->flag());
      case Type::text: return out ? out->text(as<std::string>(value)) : void(as<std::string>(value) = in->text());
      case Type::list: return elements(type, value, out ? type.content(value).count : in->count());
      case Type::array: return elements(type, value, type.content(value).count);
      case Type::optional: return elements(type, value, out ? type.content(value).count : in->flag());
      case Type::shared: return out ? put_shared(type.element(), type.content(value).first) : get_shared(type, value);
      case Type::laws: {
        out ? out->text(type.parts[type.content(value).count].name) : choose(type, value, in->text());
        auto const [law, place] = type.content(value);
        return (*this)(type.parts[place].type(), law);
      }
      case Type::fields: return fields(type, value);
    }
  }

  void numbers(void* first, std::size_t bytes) {
    auto* const place = static_cast<std::byte*>(first);
    out ? out->numbers(place, bytes) : in->numbers(place, bytes);
  }
  /// Read one by one, but for numbers: never more than there are bytes for.
  void elements(Type const& type, void* value, std::size_t count) {
    Type const& element = type.element();
    bool const of_numbers = element.kind == Type::number, grows = in && type.kind != Type::array;
    if (out && type.kind == Type::list) out->count(count);
    if (out && type.kind == Type::optional) out->flag(count > 0);
    if (grows && of_numbers && count > in->left() / element.size) throw FormatError("it ends too early");
    if (grows) type.resize(value, of_numbers ? count : 0);
    if (of_numbers) return numbers(type.content(value).first, count * element.size);
    for (std::size_t i = 0; i < count; ++i) {
      if (grows) type.resize(value, i + 1);
      (*this)(element, static_cast<std::byte*>(type.content(value).first) + i * element.size);
    }
  }
  static void choose(Type const& type, void* value, std::string const& name) {
    auto const found = std::ranges::find(type.parts, std::string_view(name), &Part::name);
    if (found == type.parts.end()) throw FormatError("it names the law " + name.substr(0, 40));
    type.resize(value, at(found - type.parts.begin()));
  }
  /// What is read against its range; no table may be missing.
  void fields(Type const& type, void* value) {
    for (std::size_t i = 0; i < type.parts.size(); ++i) {
      auto const& [name, type_of_field, unit, range, may_be_null] = type.parts[i];
      void* const field = type.field(value, i);
      (*this)(type_of_field(), field);
      if (out || may_be_null) continue;
      type_of_field().check_range(field, range, {name, unit});
      if (type_of_field().kind == Type::shared && type_of_field().content(field).first == nullptr)
        throw FormatError(std::string("model file: there is no ") + name);
    }
    if (in && type.check != nullptr) type.check(value);
  }
  /// 0: none; else its number from 1, and behind a new number the table itself.
  void put_shared(Type const& type, void* table) {
    if (table == nullptr) return out->count(0);
    auto const [at, fresh] = written.try_emplace(table, written.size() + 1);
    out->number(at->second);
    if (fresh) (*this)(type, table);
  }
  void get_shared(Type const& type, void* value) {
    auto const number = in->number<std::uint64_t>();
    if (number == 0) return type.share(value, nullptr);
    if (number > read.size() + 1) throw FormatError("a shared table is missing");
    if (number == read.size() + 1) {
      auto const made = type.make();
      read.emplace_back(&type.element(), made);
      (*this)(type.element(), made.get());
    }
    auto const& [kind, table] = read[at(number) - 1];
    if (kind != &type.element()) throw FormatError("a shared table is one of another kind");
    type.share(value, table);
  }
};

std::string word(Type const& type) {
  switch (type.kind) {
    case Type::number: return type.letter + std::to_string(8 * type.size);
    case Type::flag: return "bool";
    case Type::text: return "text";
    case Type::list: return std::string("[").append(word(type.element())) + "]";
    case Type::array: return word(type.element()) + " x " + std::to_string(type.size / type.element().size);
    case Type::optional: return word(type.element()) + "?";
    case Type::shared: return "@";
    case Type::laws: return "law";
    default: return "";
  }
}

}  // namespace

void put(ByteWriter& out, Type const& type, void const* value) { Walk{&out, nullptr}(type, const_cast<void*>(value)); }

void get(std::span<std::byte const> bytes, Type const& type, void* value) {
  ByteReader in(bytes);
  Walk{nullptr, &in}(type, value);
  if (in.left() > 0) throw FormatError("there are bytes behind its end");
}

std::string layout(Type const& type, std::string const& indent) {
  if (type.element != nullptr) return layout(type.element(), indent);
  std::string text;
  for (Part const& part : type.parts) {
    std::string const kind = type.kind == Type::laws ? "" : word(part.type());
    text += indent + (type.kind == Type::laws ? "= " : "") + part.name + (kind.empty() ? "" : " ") + kind;
    text += std::string(*part.unit == '\0' ? "" : ", ") + part.unit + "\n" + layout(part.type(), indent + "  ");
  }
  return text;
}

}  // namespace rollerrig::archive
