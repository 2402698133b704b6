"""Polygons as a file of IFC2X3, and a second reader of such files, damaged or not."""

import re

from measures import Damaged, Unknown, is_flat, number

# What leads from a product to its points: the type, and which of its arguments names the next.
PATH = {"IFCPRODUCTDEFINITIONSHAPE": 2, "IFCSHAPEREPRESENTATION": 3, "IFCFACEBASEDSURFACEMODEL": 0, "IFCFACETEDBREP": 0,
        "IFCSHELLBASEDSURFACEMODEL": 0, "IFCCONNECTEDFACESET": 0, "IFCCLOSEDSHELL": 0, "IFCOPENSHELL": 0, "IFCFACE": 0,
        "IFCFACEOUTERBOUND": 0}

HEAD = ["#1=IFCPERSON($,$,'p',$,$,$,$,$);", "#2=IFCORGANIZATION($,'o',$,$,$);", "#3=IFCPERSONANDORGANIZATION(#1,#2,$);",
        "#4=IFCAPPLICATION(#2,'1','a','a');", "#5=IFCOWNERHISTORY(#3,#4,$,.ADDED.,$,$,$,0);",
        "#6=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);", "#7=IFCUNITASSIGNMENT((#6));", "#8=IFCCARTESIANPOINT((0.,0.,0.));",
        "#9=IFCAXIS2PLACEMENT3D(#8,$,$);", "#10=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,#9,$);",
        "#11=IFCPROJECT('0000000000000000000000',#5,'p',$,$,$,$,(#10),#7);", "#12=IFCLOCALPLACEMENT($,#9);",
        "#13=IFCBUILDING('0000000000000000000001',#5,'b',$,$,#12,$,$,.ELEMENT.,$,$,$);",
        "#14=IFCRELAGGREGATES('0000000000000000000002',#5,$,$,#11,(#13));"]


def text(outlines):
    """Each is a product with one face."""
    lines, products, number = list(HEAD), [], 100
    for i, corners in enumerate(outlines):
        points = range(number, number + len(corners))
        for k, corner in zip(points, corners):
            lines.append(f"#{k}=IFCCARTESIANPOINT(({','.join(f'{x:.16E}' for x in corner)}));")
        n = points.stop
        lines += [f"#{n}=IFCPOLYLOOP(({','.join(f'#{k}' for k in points)}));", f"#{n + 1}=IFCFACEOUTERBOUND(#{n},.T.);",
                  f"#{n + 2}=IFCFACE((#{n + 1}));", f"#{n + 3}=IFCCONNECTEDFACESET((#{n + 2}));",
                  f"#{n + 4}=IFCFACEBASEDSURFACEMODEL((#{n + 3}));",
                  f"#{n + 5}=IFCSHAPEREPRESENTATION(#10,'Body','SurfaceModel',(#{n + 4}));",
                  f"#{n + 6}=IFCPRODUCTDEFINITIONSHAPE($,$,(#{n + 5}));",
                  f"#{n + 7}=IFCBUILDINGELEMENTPROXY('{i + 10:022d}',#5,'p{i}',$,$,#12,#{n + 6},$,$);"]
        products.append(f"#{n + 7}")
        number = n + 8
    lines.append(f"#15=IFCRELCONTAINEDINSPATIALSTRUCTURE('0000000000000000000003',#5,$,$,({','.join(products)}),#13);")
    return ("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
            "FILE_SCHEMA(('IFC2X3'));\nENDSEC;\nDATA;\n" + "\n".join(lines) + "\nENDSEC;\nEND-ISO-10303-21;\n")


def arguments(text):
    """Parted at commas outside of brackets and strings."""
    found, depth, in_string = [""], 0, False
    for c in text:
        in_string ^= c == "'"
        if c == "," and depth == 0 and not in_string:
            found.append("")
            continue
        depth += (c == "(") - (c == ")") if not in_string else 0
        found[-1] += c
    return [argument.strip() for argument in found]


class Reader:
    def __init__(self, data):
        text = data.decode(errors="replace")
        if not all(line in text for line in HEAD):
            raise Unknown("other places or units")
        self.statements = {}
        for number, kind, inside in re.findall(r"#(\d+)\s*=\s*(\w+)\s*\((.*)\)\s*;", text):
            if number in self.statements:
                raise Damaged(f"a second #{number}")
            self.statements[number] = (kind, arguments(inside))
        self.polygons = []
        for kind, inside in list(self.statements.values()):
            if kind == "IFCRELCONTAINEDINSPATIALSTRUCTURE":
                for product in re.findall(r"#(\d+)", inside[4]):
                    self.product(*self.named(product))

    def named(self, number):
        if number not in self.statements:
            raise Damaged(f"#{number} is named and is not there")
        return self.statements[number]

    def product(self, kind, inside):
        if kind != "IFCBUILDINGELEMENTPROXY" or inside[5] != "#12":
            raise Unknown(kind)
        self.follow(inside[6])

    def follow(self, references):
        for number in re.findall(r"#(\d+)", references):
            kind, inside = self.named(number)
            if kind == "IFCPOLYLOOP":
                self.polygons.append([self.point(*self.named(point)) for point in re.findall(r"#(\d+)", inside[0])])
                if inside[0] == "" or len(self.polygons[-1]) < 3:
                    raise Damaged("a loop")
            elif kind in PATH:
                self.follow(inside[PATH[kind]])
            else:
                raise Unknown(kind)

    @staticmethod
    def point(kind, inside):
        if kind != "IFCCARTESIANPOINT":
            raise Damaged(kind)
        numbers = [number(x.strip().encode()) for x in inside[0].strip("()").split(",")]
        if len(numbers) != 3:
            raise Damaged("a point")
        return tuple(numbers)


def polygons(data, _=None):
    found = Reader(data).polygons
    if not all(map(is_flat, found)):
        raise Unknown("a polygon that is not flat")
    return found
