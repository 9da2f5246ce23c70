#!/usr/bin/env python3
"""Looks whether the elements of an ESI file fit together: order of elements, references, lengths, nothing that is obsolete.

usage: esi.py FILE...
       esi.py --committed ECTWIN FOLDER   regenerates the files of FOLDER, expects no difference, then checks them
       esi.py --write ECTWIN FOLDER       regenerates them: ESI of each family, SII of each device
       esi.py --schema FILE...            against the schema that $ECTWIN_ESI_SCHEMA names; 77 without one
       esi.py --self FILE                 makes one mistake after another in a copy and wants each to be found
"""
import copy
import os
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET

# The schema's order (ETG.2000), of what we write.
ORDER = {
    "EtherCATInfo": "Vendor Descriptions",
    "Vendor": "Id Name",
    "Descriptions": "Groups Devices",
    "Group": "Type Name",
    "Device": "Type Name Info GroupType Profile Fmmu Sm RxPdo TxPdo Mailbox Dc Eeprom",
    "Timeout": "PreopTimeout SafeopOpTimeout BackToInitTimeout BackToSafeopTimeout RequestTimeout ResponseTimeout",
    "Profile": "ProfileNo AddInfo Dictionary",
    "Dictionary": "DataTypes Objects",
    "DataType": "Name BaseType BitSize ArrayInfo SubItem EnumInfo",
    "Object": "Index Name Type BitSize Info Flags",
    "Flags": "Access Category PdoMapping Backup Setting",
    "RxPdo": "Index Name Exclude Entry",
    "TxPdo": "Index Name Exclude Entry",
    "Entry": "Index SubIndex BitLen Name Comment DataType",
    "Mailbox": "Timeout AoE EoE CoE FoE SoE VoE",
    "CoE": "InitCmd",
    "InitCmd": "Transition Index SubIndex Data Comment",
    "OpMode": "Name Desc AssignActivate CycleTimeSync0 ShiftTimeSync0 CycleTimeSync1 ShiftTimeSync1",
    "Eeprom": "Data ByteSize ConfigData BootStrap",
}
OBSOLETE = {"TcSmClass", "TcCfgModeSafeOp", "DownloadModuleList", "ProductRevision", "OpOnly", "OneByteMode", "Watchdog",
            "FixedAssignment", "DS402Channels", "StationAliasSupported", "PdoOrder", "Crc32"}


def number(text):
    return int(text[2:], 16) if text.startswith("#x") else int(text)


class File:
    def __init__(self, name, root):
        self.name, self.root, self.wrong = name, root, []
        self.order()
        groups = [g.findtext("Type") for g in root.findall("Descriptions/Groups/Group")]
        self.want(len(set(groups)) == len(groups), "two groups have the same Type")
        keys = []
        for device in root.findall("Descriptions/Devices/Device"):
            kind = device.find("Type")
            self.where = kind.text
            keys.append((number(kind.get("ProductCode")), number(kind.get("RevisionNo"))))
            self.want(device.findtext("GroupType") in groups, f"GroupType {device.findtext('GroupType')} is no group")
            self.types(device)
            self.objects(device)
            self.pdos(device)
            self.eeprom(device)
        self.where = "file"
        self.want(len(set(keys)) == len(keys), "two devices have the same product code and revision")
        self.want(bool(keys), "there is no device")

    where = "file"

    def want(self, fine, what):
        if not fine:
            self.wrong.append(f"{self.name}: {self.where}: {what}")

    def order(self):
        for element in self.root.iter():
            for old in OBSOLETE & (set(element.attrib) | {element.tag}):
                self.want(False, f"{element.tag} has {old}, which is obsolete")
            wanted = ORDER.get(element.tag, "").split()
            tags = [child.tag for child in element]
            if not wanted or element.tag == "Info":
                continue
            unknown = [tag for tag in tags if tag not in wanted]
            self.want(not unknown, f"{element.tag} has {unknown}")
            places = [wanted.index(tag) for tag in tags if tag in wanted]
            self.want(places == sorted(places), f"{element.tag}: {tags} is not the schema's order")

    def types(self, device):
        self.bits, self.items, self.counts = {}, {}, {}
        for kind in device.findall("Profile/Dictionary/DataTypes/DataType"):
            name, bits = kind.findtext("Name"), int(kind.findtext("BitSize"))
            self.want(name not in self.bits, f"type {name} occurs twice")
            base, array = kind.findtext("BaseType"), kind.find("ArrayInfo")
            self.want(base is None or base in self.bits, f"type {name}: there is no {base} before it")
            if array is not None:
                self.counts[name] = int(array.findtext("Elements"))
            if array is not None and base in self.bits:
                self.want(bits == self.bits[base] * int(array.findtext("Elements")), f"type {name} is not its elements")
            self.bits[name], self.items[name] = bits, kind.findall("SubItem")
            self.sub_items(name, bits)

    def sub_items(self, name, bits):
        end, names = 0, set()
        for item in self.items[name]:
            size, offset, kind = int(item.findtext("BitSize")), int(item.findtext("BitOffs")), item.findtext("Type")
            what = f"type {name}, {item.findtext('Name')}"
            self.want(item.findtext("Name") not in names, f"{what} occurs twice")
            self.want(kind in self.bits, f"{what}: there is no type {kind}")
            self.want(size == self.bits.get(kind, size), f"{what}: {size} bits, its type {self.bits.get(kind)}")
            self.want(offset >= end and offset - end < 8, f"{what} begins at {offset}, the one before ends at {end}")
            names.add(item.findtext("Name"))
            end = max(offset + size, 16)
        self.want(not self.items[name] or bits == end, f"type {name} has {bits} bits, its sub-items {end}")

    def objects(self, device):
        self.mappable, last = {}, -1
        for entry in device.findall("Profile/Dictionary/Objects/Object"):
            index, kind = number(entry.findtext("Index")), entry.findtext("Type")
            what = f"object {index:04X}"
            self.want(index > last, f"{what} does not stand in ascending order")
            last = index
            self.want(kind in self.bits, f"{what}: there is no type {kind}")
            self.want(int(entry.findtext("BitSize")) == self.bits.get(kind), f"{what} is not as long as its type")
            self.defaults(what, entry, kind)
            for item in self.items.get(kind, []) or [entry]:
                subs = self.indices(item)
                for sub in subs:
                    bits = int(item.findtext("BitSize")) // len(subs)
                    self.mappable[index, sub] = (bits, item.findtext("Flags/PdoMapping") or "")

    def indices(self, item):
        if item.tag == "Object":
            return [0]
        sub = item.findtext("SubIdx")
        if sub is not None:
            return [number(sub)]
        return list(range(1, self.counts.get(item.findtext("Type"), 1) + 1))

    def defaults(self, what, entry, kind):
        info = entry.findall("Info/SubItem")
        if not self.items.get(kind):
            pairs = [(entry.find("Info"), self.bits.get(kind, 0))]
        else:
            sizes = [(item, len(self.indices(item)), i) for item in self.items[kind] for i in self.indices(item)]
            self.want(len(info) == len(sizes), f"{what}: Info has {len(info)} sub-items, its type {len(sizes)}")
            names = [item.findtext("Name") if item.find("SubIdx") is not None else f"SubIndex {i:03}"
                     for item, _, i in sizes]
            self.want([i.findtext("Name") for i in info] == names, f"{what}: Info names other sub-items than its type")
            pairs = [(i.find("Info"), int(item.findtext("BitSize")) // count) for i, (item, count, _) in zip(info, sizes)]
        for element, bits in pairs:
            data = element.findtext("DefaultData")
            self.want(data is None or len(data) == 2 * ((bits + 7) // 8) or kind.startswith("STRING"),
                      f"{what}: DefaultData {data} is not of {bits} bits")
            low, high, value = (element.findtext(tag) for tag in ("MinValue", "MaxValue", "DefaultValue"))
            self.want(low is None or int(low) <= int(value) <= int(high), f"{what}: {value} is not in {low}..{high}")

    def pdos(self, device):
        bits, indices = {}, []
        for pdo in device.findall("RxPdo") + device.findall("TxPdo"):
            index, sm = number(pdo.findtext("Index")), pdo.get("Sm")
            what = f"PDO {index:04X}"
            indices.append(index)
            self.want((0x1600 if pdo.tag == "RxPdo" else 0x1A00) <= index < (0x1800 if pdo.tag == "RxPdo" else 0x1C00),
                      f"{what} is no {pdo.tag}")
            length = sum(int(entry.findtext("BitLen")) for entry in pdo.findall("Entry"))
            if sm is not None:
                bits[int(sm)] = bits.get(int(sm), 0) + length
            for entry in pdo.findall("Entry"):
                self.entry(what, pdo.tag, entry)
        for index in (number(e.text) for e in device.iter("Exclude")):
            self.want(index in indices, f"{index:04X} is excluded and no PDO")
        self.want(len(set(indices)) == len(indices), "a PDO occurs twice")
        self.sms(device, bits)

    def entry(self, what, tag, entry):
        key = number(entry.findtext("Index")), int(entry.findtext("SubIndex") or 0)
        length = int(entry.findtext("BitLen"))
        self.want(1 <= length <= 255, f"{what}: an entry of {length} bits")
        if key[0] == 0:
            self.want(entry.find("DataType") is None, f"{what}: a gap has a type")
        elif self.mappable:
            bits, mapping = self.mappable.get(key, (0, ""))
            self.want(bits >= length, f"{what}: {key[0]:04X}:{key[1]} has {bits} bits, {length} are mapped")
            self.want(tag[0] in mapping, f"{what}: {key[0]:04X}:{key[1]} is not for an {tag}")

    def sms(self, device, bits):
        roles = {"Outputs": "RxPdo", "Inputs": "TxPdo"}
        sms = device.findall("Sm")
        for n, sm in enumerate(sms):
            size = int(sm.get("DefaultSize"))
            self.want(int(sm.get("Enable")) == (size > 0), f"Sm {n} is enabled and has nothing, or the other way round")
            if sm.text in roles:
                self.want(size == (bits.get(n, 0) + 7) // 8, f"Sm {n}: DefaultSize {size}, its PDOs {bits.get(n, 0)} bits")
            elif sm.get("MinSize"):
                self.want(int(sm.get("MinSize")) <= size <= int(sm.get("MaxSize")), f"Sm {n}: its size is not within its limits")
        for pdo in device.findall("RxPdo") + device.findall("TxPdo"):
            sm = pdo.get("Sm")
            self.want(sm is None or int(sm) < len(sms) and roles.get(sms[int(sm)].text) == pdo.tag,
                      f"PDO {pdo.findtext('Index')} is assigned to Sm {sm}, which is none for it")

    def eeprom(self, device):
        eeprom = device.find("Eeprom")
        data, boot = eeprom.findtext("ConfigData"), eeprom.findtext("BootStrap")
        self.want(data is None or len(data) == 28, "ConfigData does not have 14 bytes")
        self.want(boot is None or len(boot) == 16, "BootStrap does not have 8 bytes")
        size = int(eeprom.findtext("ByteSize") or 128)
        self.want(size % 128 == 0 and size > 0, f"an EEPROM of {size} bytes")


def check(path):
    return File(str(path), ET.parse(path).getroot()).wrong


def generate(ectwin, folder):
    """The ESI of each product family, and the SII image of each device as Intel HEX."""
    subprocess.run([ectwin, "esi", "--all", "-o", folder], check=True)
    listed = subprocess.run([ectwin, "list"], check=True, capture_output=True, text=True).stdout
    for device in (line.split()[0] for line in listed.splitlines()):
        image = str(pathlib.Path(folder) / f"{device}.hex")
        subprocess.run([ectwin, "sii", device, "--format", "hex", "-o", image], check=True)
    return []


def committed(ectwin, folder):
    wrong = []
    with tempfile.TemporaryDirectory() as work:
        generate(ectwin, work)
        ours, theirs = sorted(os.listdir(folder)), sorted(os.listdir(work))
        if ours != theirs:
            wrong.append(f"{folder} has {ours}, expected {theirs}")
        for name in set(ours) & set(theirs):
            if (pathlib.Path(folder) / name).read_bytes() != (pathlib.Path(work) / name).read_bytes():
                wrong.append(f"{folder}/{name} is not what the devices say now: run tests/check/esi.py --write ECTWIN esi")
            wrong += check(pathlib.Path(work) / name) if name.endswith(".xml") else []
    return wrong


MISTAKES = {
    "a PDO longer than its SyncManager": ("Sm[3]", lambda e: e.set("DefaultSize", "1")),
    "a PDO of another SyncManager": ("TxPdo", lambda e: e.set("Sm", "2")),
    "an entry longer than its object": ("TxPdo/Entry/BitLen", lambda e: setattr(e, "text", "200")),
    "an entry of no object": ("TxPdo/Entry/Index", lambda e: setattr(e, "text", "#x5555")),
    "a group that is not there": ("GroupType", lambda e: setattr(e, "text", "other")),
    "an unknown type": ("Profile/Dictionary/Objects/Object/Type", lambda e: setattr(e, "text", "NONE")),
    "an object of another length": ("Profile/Dictionary/Objects/Object/BitSize", lambda e: setattr(e, "text", "7")),
    "a sub-item at another place": ("Profile/Dictionary/DataTypes/DataType/SubItem[2]/BitOffs",
                                    lambda e: setattr(e, "text", "8")),
    "a default of another length": (".//DefaultData", lambda e: setattr(e, "text", "00")),
    "an attribute that is obsolete": ("Sm", lambda e: e.set("OpOnly", "true")),
    "a short ConfigData": ("Eeprom/ConfigData", lambda e: setattr(e, "text", "00")),
    "another order": ("Eeprom", lambda e: e.insert(0, e[-1])),
}


def self_test(path):
    wrong, root = [], ET.parse(path).getroot()
    for what, (place, change) in MISTAKES.items():
        changed = copy.deepcopy(root)
        change(changed.find("Descriptions/Devices/Device").find(place))
        if not File(what, changed).wrong:
            wrong.append(f"{what}: nothing was found wrong")
    return wrong


def schema(files):
    path = os.environ.get("ECTWIN_ESI_SCHEMA")
    if not path:
        print("skipped: ECTWIN_ESI_SCHEMA names no schema")
        sys.exit(77)
    return [] if subprocess.run(["xmllint", "--noout", "--schema", path, *files]).returncode == 0 else ["not valid"]


def main():
    arguments = sys.argv[1:]
    modes = {"--committed": lambda rest: committed(*rest), "--write": lambda rest: generate(*rest), "--schema": schema,
             "--self": lambda rest: self_test(*rest)}
    if arguments[0] in modes:
        wrong = modes[arguments[0]](arguments[1:])
    else:
        wrong = [line for path in arguments for line in check(path)]
    print(*wrong, sep="\n", end="\n" if wrong else "")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
