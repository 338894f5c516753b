// Opens a .nvdb file with NanoVDB's own headers and lets them judge every grid.
//
//     g++ -std=c++17 -O2 scripts/check_nvdb.cpp -o check_nvdb      Debian: libnanovdb-dev
//     ./check_nvdb FILE.nvdb
//
// Prints one line per grid. Exit code 0: every grid is valid in detail and its full checksum holds; 1: one is not.

#include <cstdio>
#include <exception>
#include <iostream>  // GridValidator.h writes to std::cerr without it

#include <nanovdb/util/GridChecksum.h>
#include <nanovdb/util/GridValidator.h>
#include <nanovdb/util/IO.h>

template <typename Value>
bool judge(const nanovdb::NanoGrid<Value>& grid) {
    const bool valid = nanovdb::isValid(grid, true, true);
    const bool checksum = nanovdb::validateChecksum(grid, nanovdb::ChecksumMode::Full);
    std::printf("%-10s type %-6s class %-4s %10llu active voxels  valid %d  checksum %d\n", grid.gridName(),
                nanovdb::toStr(grid.gridType()), nanovdb::toStr(grid.gridClass()),
                static_cast<unsigned long long>(grid.activeVoxelCount()), valid, checksum);
    return valid && checksum;
}

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "one FILE.nvdb is needed\n");
        return 2;
    }
    try {
        bool sound = true;
        for (auto& handle : nanovdb::io::readGrids(argv[1])) {
            if (const auto* floats = handle.grid<float>()) {
                sound = judge(*floats) && sound;
            } else if (const auto* ints = handle.grid<int32_t>()) {
                sound = judge(*ints) && sound;
            } else {
                std::printf("a grid that is neither Float nor Int32\n");
                sound = false;
            }
        }
        return sound ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
