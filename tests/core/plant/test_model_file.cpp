#include "rollerrig/plant/model_file.hpp"

#include <doctest/doctest.h>

#include <cstring>
#include <string>

#include "models.hpp"
#include "rollerrig/plant/byte_stream.hpp"

using namespace rollerrig;

namespace {

using Bytes = std::vector<std::byte>;

/// What reading refuses with; empty: it did not.
std::string refusal(std::span<std::byte const> bytes) {
  try {
    read_model(bytes);
    return "";
  } catch (std::invalid_argument const& error) {
    return error.what();
  }
}

Bytes with_checksum(Bytes bytes) {
  std::span<std::byte const> const all = bytes;
  std::uint64_t const crc = crc64(all.subspan(48), crc64(all.first(40)));
  std::memcpy(bytes.data() + 40, &crc, sizeof crc);
  return bytes;
}

/// Not zero; another one for each place.
std::byte change_at(std::size_t place) { return static_cast<std::byte>(1 + (place * 2654435761U >> 7) % 255); }

std::vector<double> course(AssembledModel const& assembled) {
  Driver driver(assembled.model, assembled.setup);
  integrate::Options options = assembled.options;
  options.output_step = 0.01;
  REQUIRE(driver.start(options, assembled.start_time, assembled.start.data()) == Status::ok);
  std::vector<double> rows, row(static_cast<std::size_t>(driver.width()));
  driver.advance(0.2, [&](double t, double const* x, double const* z) {
    driver.record(t, x, z, row.data());
    rows.insert(rows.end(), row.begin(), row.end());
  });
  return rows;
}

bool same_bits(std::vector<double> const& a, std::vector<double> const& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

}  // namespace

TEST_CASE("the checksum is CRC-64/XZ") {
  std::string const check = "123456789";
  CHECK(crc64(std::as_bytes(std::span(check))) == 0x995DC9BBDF1939FAULL);  // the catalogue of CRCs' check value
  std::string const longer = "123456789123456789";
  auto const bytes = std::as_bytes(std::span(longer));
  CHECK(crc64(bytes.subspan(7), crc64(bytes.first(7))) == crc64(bytes));
}

TEST_CASE("a model read from its file runs the same course, bit for bit, and gives the same file") {
  for (AssembledModel const& written : {test::assembled(test::small_parts(true)), test::braked()}) {
    Bytes const bytes = write_model(written);
    CHECK(write_model(written) == bytes);
    AssembledModel const read = read_model(bytes);
    CHECK(write_model(read) == bytes);
    auto const before = course(written);
    REQUIRE(before.size() > 100);
    CHECK(same_bits(course(read), before));
  }
}

TEST_CASE("every changed byte of a model file is refused") {
  Bytes bytes = write_model(test::braked());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] ^= change_at(i);
    std::string const what = refusal(bytes);
    CHECK_MESSAGE(what.starts_with("model file: "), "byte " << i);
    if (i >= 48) CHECK(what.find("changed") != std::string::npos);
    bytes[i] ^= change_at(i);
  }
  CHECK(refusal(bytes).empty());
}

TEST_CASE("a model file that is cut anywhere, or goes on, is refused") {
  Bytes bytes = write_model(test::braked());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    std::string const what = refusal(std::span(bytes).first(size));
    CHECK_MESSAGE(what.find("cut") != std::string::npos, size << ": " << what);
  }
  bytes.push_back(std::byte{0});
  CHECK(refusal(bytes).find("too many") != std::string::npos);
}

TEST_CASE("a model file of another version or layout is refused by name") {
  Bytes bytes = write_model(test::braked());
  Bytes other = bytes;
  other[16] = std::byte{2};
  CHECK(refusal(with_checksum(other)) ==
        "model file: of version 2, this rollerrig reads version 1; assemble the case again");
  other = bytes;
  other[48] = std::byte{'N'};
  CHECK(refusal(with_checksum(other)).find("its layout is not that of this rollerrig") != std::string::npos);
  other = bytes;
  other[0] = std::byte{'R'};
  CHECK(refusal(with_checksum(other)).find("it is none") != std::string::npos);
}

TEST_CASE("wrong bytes under a right checksum are a refusal or a model, never a crash") {
  Bytes const bytes = write_model(test::braked());
  std::size_t const begin = 48 + model_layout().size();
  int refused = 0, read = 0;
  for (std::size_t i = begin; i < bytes.size(); i += 5) {
    Bytes changed = bytes;
    changed[i] ^= change_at(i);
    (refusal(with_checksum(changed)).empty() ? read : refused) += 1;
  }
  CHECK(refused > 100);
  CHECK(read > 100);  // another mass is a model too
}
