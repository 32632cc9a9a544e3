#include "rollerrig/plant/archive.hpp"

#include <algorithm>
#include <map>

namespace rollerrig::archive {
namespace {

std::byte const* place(void const* first, std::size_t bytes) { return static_cast<std::byte const*>(first) + bytes; }

/// Tables that have been met are counted in the order of their first places.
struct Writer {
  ByteWriter& out;
  std::map<void const*, std::uint64_t> written{};

  void put(Type const& type, void const* value) {
    auto const [first, count] = type.content != nullptr ? type.content(value) : Type::Content{value, 1};
    switch (type.kind) {
      case Type::number: return out.numbers(place(value, 0), type.size);
      case Type::flag: return out.flag(as<bool>(value));
      case Type::text: return out.text(as<std::string>(value));
      case Type::list: out.count(count); return put_all(type.element(), first, count);
      case Type::array: return put_all(type.element(), first, count);
      case Type::optional: out.flag(count > 0); return put_all(type.element(), first, count);
      case Type::shared: return put_shared(type.element(), first);
      case Type::laws: out.text(type.parts[count].name); return put(type.parts[count].type(), first);
      case Type::fields:
        for (std::size_t i = 0; i < type.parts.size(); ++i) put(type.parts[i].type(), type.field(value, i));
    }
  }
  void put_all(Type const& type, void const* first, std::size_t count) {
    if (type.kind == Type::number) return out.numbers(place(first, 0), count * type.size);
    for (std::size_t i = 0; i < count; ++i) put(type, place(first, i * type.size));
  }
  /// 0: none; else its number from 1, and behind a new number the table itself.
  void put_shared(Type const& type, void const* table) {
    if (table == nullptr) return out.count(0);
    auto const [at, fresh] = written.try_emplace(table, written.size() + 1);
    out.number(at->second);
    if (fresh) put(type, table);
  }
};

struct Reader {
  ByteReader in;
  std::vector<std::pair<Type const*, std::shared_ptr<void const>>> read{};  ///< tables, and what each is

  void get(Type const& type, void* value) {
    switch (type.kind) {
      case Type::number: return in.numbers(static_cast<std::byte*>(value), type.size);
      case Type::flag: *static_cast<bool*>(value) = in.flag(); return;
      case Type::text: *static_cast<std::string*>(value) = in.text(); return;
      case Type::list: return get_list(type, value, in.count());
      case Type::array: return get_all(type.element(), value, type.content(value).count);
      case Type::optional:
        type.resize(value, 0);
        if (in.flag()) add(type, value, 0);
        return;
      case Type::shared: return get_shared(type, value);
      case Type::laws: return get_law(type, value);
      case Type::fields:
        for (std::size_t i = 0; i < type.parts.size(); ++i) {
          auto* const field = const_cast<void*>(type.field(value, i));
          get(type.parts[i].type(), field);
          if (!type.parts[i].may_be_null) check(type.parts[i], field);
        }
        if (type.check != nullptr) type.check(value);
    }
  }
  /// What the range says, and that no table is missing.
  static void check(Part const& part, void const* value) {
    part.type().check_range(value, part.range, {part.name, part.unit});
    if (part.type().kind == Type::shared && part.type().content(value).first == nullptr)
      throw FormatError(std::string("model file: there is no ") + part.name);
  }
  void get_all(Type const& type, void* first, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) get(type, static_cast<std::byte*>(first) + i * type.size);
  }
  static std::byte* first(Type const& type, void* value) {
    return static_cast<std::byte*>(const_cast<void*>(type.content(value).first));
  }
  void add(Type const& type, void* value, std::size_t behind) {
    type.resize(value, behind + 1);
    get(type.element(), first(type, value) + behind * type.element().size);
  }
  void get_list(Type const& type, void* value, std::size_t count) {
    bool const numbers = type.element().kind == Type::number;
    if (numbers && count > in.left() / type.element().size) throw FormatError("it ends too early");
    type.resize(value, numbers ? count : 0);
    if (numbers) return in.numbers(first(type, value), count * type.element().size);
    for (std::size_t i = 0; i < count; ++i) add(type, value, i);
  }
  void get_law(Type const& type, void* value) {
    std::string const name = in.text();
    auto const found = std::ranges::find(type.parts, std::string_view(name), &Part::name);
    if (found == type.parts.end()) throw FormatError("it names the law " + name.substr(0, 40));
    type.resize(value, static_cast<std::size_t>(found - type.parts.begin()));
    get(found->type(), first(type, value));
  }
  void get_shared(Type const& type, void* value) {
    type.share(value, nullptr);
    auto const number = in.number<std::uint64_t>();
    if (number == 0) return;
    if (number > read.size() + 1) throw FormatError("a shared table is missing");
    if (number <= read.size()) {
      auto const& [kind, table] = read[static_cast<std::size_t>(number) - 1];
      if (kind != &type.element()) throw FormatError("a shared table is one of another kind");
      return type.share(value, table);
    }
    auto const made = type.make();
    read.emplace_back(&type.element(), made);
    get(type.element(), made.get());
    type.share(value, made);
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
    case Type::fields: break;
  }
  return "";
}

}  // namespace

void put(ByteWriter& out, Type const& type, void const* value) { Writer{out}.put(type, value); }

void get(std::span<std::byte const> bytes, Type const& type, void* value) {
  Reader reader{ByteReader(bytes)};
  reader.get(type, value);
  if (reader.in.left() > 0) throw FormatError("there are bytes behind its end");
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
