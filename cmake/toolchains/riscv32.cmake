# Debian's compiler for bare RISC-V makes code for 32 bits too. It comes without a C library, and the core needs little of one:
# firmware/libc has that.
set(CMAKE_SYSTEM_PROCESSOR riscv32)
set(tools riscv64-unknown-elf)
set(cpu "-march=rv32imac -mabi=ilp32 -ffreestanding -isystem ${CMAKE_CURRENT_LIST_DIR}/../../firmware/libc")
set(libc "-nostdlib")
set(CMAKE_C_STANDARD_LIBRARIES_INIT "-lgcc")
include(${CMAKE_CURRENT_LIST_DIR}/bare-metal.cmake)
