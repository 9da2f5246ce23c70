/* SPDX-License-Identifier: MIT */
#include "check/check.h"

#include "check/internal.h"

bool ect_device_check(const ect_device_t *device, char *text, size_t room)
{
    const report_t r = {.device = device, .od = ect_device_od(device, NULL), .text = text, .room = room};
    (void)wrong(&r, "%s", "");
    return check_names(&r) && check_esc(&r) && check_objects(&r) && check_details(&r) && check_pdos(&r) &&
           check_layout(&r) && check_offers(&r) && check_sii(&r);
}
