# Common to all processors without an operating system; included by their toolchain files, which set the compiler and `cpu`.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY) # a program would need the board's linker script
set(CMAKE_C_COMPILER ${tools}-gcc)
set(CMAKE_ASM_COMPILER ${tools}-gcc)
set(CMAKE_OBJCOPY ${tools}-objcopy)
set(CMAKE_SIZE ${tools}-size)
set(CMAKE_C_FLAGS_INIT "${cpu} -ffunction-sections -fdata-sections")
set(CMAKE_ASM_FLAGS_INIT "${cpu}")
# nmagic: a segment holds what the linker script puts there, and not the headers of the file in the page before it.
set(CMAKE_EXE_LINKER_FLAGS_INIT "${libc} -nostartfiles -Wl,--gc-sections -Wl,--nmagic -Wl,--fatal-warnings")
set(CMAKE_EXECUTABLE_SUFFIX .elf)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
