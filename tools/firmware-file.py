#!/usr/bin/env python3
"""Makes a file for FoE out of a firmware's image: the header that firmware/update.h describes, and the image.

usage: firmware-file.py IMAGE.bin ADDRESS FILE
"""
import struct
import sys
import zlib


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__.strip().splitlines()[-1])
    with open(sys.argv[1], "rb") as source:
        image = source.read()
    check = zlib.crc32(image)
    with open(sys.argv[3], "wb") as file:
        file.write(struct.pack("<4sIII", b"ETFW", len(image), check, int(sys.argv[2], 0)) + image)


if __name__ == "__main__":
    main()
