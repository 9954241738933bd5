// SPDX-License-Identifier: MIT
#include "flash_file.h"

#include "files.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

using FlashUnit = std::array<uint8_t, HAL_STORE_UNIT_BYTES>;

constexpr std::size_t FLASH_BYTES =
    std::size_t{HAL_FLASH_SLOTS} * HAL_STORE_UNITS * HAL_STORE_UNIT_BYTES;

} // namespace

hal_host_flash_t read_flash(const std::string &path, unsigned seed)
{
    hal_host_flash_t flash;
    hal_host_flash_init(&flash, seed);
    if (!is_there(path)) {
        return flash;
    }
    const std::string bytes = read_bytes(path);
    if (bytes.size() != FLASH_BYTES) {
        fail({path, 0}, "", "", fmt::format("has {} bytes", bytes.size()),
             fmt::format("the {} bytes of a flash, or no file", FLASH_BYTES));
    }
    auto from = bytes.begin();
    for (uint32_t slot = 0; slot < HAL_FLASH_SLOTS; slot++) {
        for (uint32_t unit = 0; unit < HAL_STORE_UNITS; unit++) {
            FlashUnit programmed{};
            std::copy_n(from, programmed.size(), programmed.begin());
            from += static_cast<std::ptrdiff_t>(programmed.size());
            (void)hal_host_flash_program(&flash, slot, unit, programmed.data());
        }
    }
    return flash;
}

void write_flash(OutputFile &file, hal_host_flash_t flash)
{
    for (uint32_t slot = 0; slot < HAL_FLASH_SLOTS; slot++) {
        for (uint32_t unit = 0; unit < HAL_STORE_UNITS; unit++) {
            FlashUnit found{};
            (void)hal_host_flash_read(&flash, slot, unit, found.data());
            file.write({reinterpret_cast<const char *>(found.data()), found.size()});
        }
    }
    file.close();
}

} // namespace nf::live
