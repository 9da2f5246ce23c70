/* SPDX-License-Identifier: MIT */
#include "board.h"

int main(int argc, char **argv)
{
    return ectwin_board_main(argc, argv);
}
