"""Coded text (docs/STREAM.md, section 7)."""

from .coder import Bit, Substream, Symbol

TYPICAL = (
    b'Ns 250.000000Ka 1.000000 1.000000 1.000000Kd 0.800000 0.800000 0.800000Ks 0.500000 0.500'
    b'000 0.500000Ke 0.000000 0.000000 0.000000Ni 1.450000d 1.000000illum 2map_Kd texture.png{'
    b'"asset":{"version":"2.0","generator":"COLLADA2GLTF"},"scene":0,"scenes":[{"nodes":[0]}],'
    b'"nodes":[{"name":"Node","children":[1,2],"mesh":0,"skin":0,"matrix":[1.0,0.0,0.0,0.0,0.0'
    b',1.0],"translation":[0.0,0.0,0.0],"rotation":[0.0,0.0,0.0,1.0],"scale":[1.0,1.0,1.0]}],"'
    b'meshes":[{"primitives":[{"attributes":{},"material":0}],"name":"Mesh"}],"materials":[{"p'
    b'brMetallicRoughness":{"baseColorFactor":[0.8,0.8,0.8,1.0],"baseColorTexture":{"index":0}'
    b',"metallicRoughnessTexture":{"index":1},"metallicFactor":0.0,"roughnessFactor":1.0},"nor'
    b'malTexture":{"index":2},"occlusionTexture":{"index":1},"emissiveTexture":{"index":3},"em'
    b'issiveFactor":[1.0,1.0,1.0],"doubleSided":true,"alphaMode":"BLEND","name":"Material"}],"'
    b'textures":[{"sampler":0,"source":0},{"sampler":0,"source":1}],"images":[{"uri":"Default_'
    b'albedo.jpg"},{"bufferView":0,"mimeType":"image/png"}],"samplers":[{"magFilter":9729,"min'
    b'Filter":9987,"wrapS":10497,"wrapT":10497}],"skins":[{"inverseBindMatrices":0,"joints":[2'
    b',3,4],"skeleton":2}],"animations":[{"channels":[{"sampler":0,"target":{"node":2,"path":"'
    b'translation"}},{"sampler":1,"target":{"node":3,"path":"rotation"}}],"samplers":[{"input"'
    b':1,"output":2,"interpolation":"LINEAR"}]}],"accessors":[{"bufferView":0,"componentType":'
    b'5126,"count":2,"type":"MAT4","max":[1.0],"min":[0.0]},{"bufferView":1,"byteOffset":48,"c'
    b'omponentType":5126,"count":2,"type":"VEC4"}],"bufferViews":[{"buffer":0,"byteOffset":0,"'
    b'byteLength":64}],"buffers":[{"byteLength":64}]}'
)

TYPICAL_HEADERS = bytes.fromhex(
    "180c140000000100a001bc016000010001002500010200ff03a006ac020002"
    "16010025000300150001030001940ab410bc05000300010025000200350003"
    "0015000104000102a01ff02ea8140004000500330101002500030015000600"
    "3500010500010203b06da09c01a84600031605003301010025000600350001"
    "04000102e0d40390bf05c0b802000400010025000300150005003101060035"
    "00010500010203c919f420fc11000300010025000300150002003500010400"
    "0102"
)


class Model:
    """A text so far, and what is expected to follow. ``byte`` says how the next one is coded."""

    def __init__(self):
        self.text, self.run = bytearray(), 0
        self.places = [[0] * 65536, [0] * 65536]
        self.matches = [[Bit() for _ in range(16)] for _ in range(2)]
        self.literals = {}

    def byte(self, coder, byte=None):
        """Codes the next byte; a coder that reads does not know it."""
        slots = self._hashes()
        near, far = (places[slot] for places, slot in zip(self.places, slots, strict=True))
        place, found = far or near, None
        if place:
            context = self.matches[1 if far else 0][min(self.run, 15)]
            if coder.bit(context, self.text[place] == byte):
                found = self.text[place]
        self.run = 0 if found is None else self.run + 1
        if found is None:
            before = self.text[-1] if self.text else 0
            high, lows = self.literals.setdefault(before, (Symbol(), {}))
            upper = coder.symbol(high, None if byte is None else byte >> 4)
            low = lows.setdefault(upper, Symbol())
            found = upper << 4 | coder.symbol(low, None if byte is None else byte & 15)
        for places, slot in zip(self.places, slots, strict=True):
            places[slot] = len(self.text)
        self.text.append(found)

    def _hashes(self):
        end = len(self.text)
        word = lambda back: (
            int.from_bytes(self.text[end - back : end - back + 4], "little") if end >= back else 0
        )
        near = word(4) * 0x9E3779B1 & 0xFFFFFFFF
        far = (near + word(8)) * 0x85EBCA77 & 0xFFFFFFFF
        return near >> 16, far >> 16


class _Primer:
    """Updates contexts by known text; nothing is read."""

    def bit(self, context, value):
        context.update(value)
        return value

    def symbol(self, context, value):
        context.update(value)
        return value


class _Reader:
    """Reads a substream."""

    def __init__(self, substream):
        self.substream = substream

    def bit(self, context, _):
        return self.substream.bit(context)

    def symbol(self, context, _):
        return self.substream.symbol(context)


class TextCodec:
    """Decodes texts, each after those before it, the first after the typical ones."""

    def __init__(self, typical=b""):
        self.model = Model()
        known = _Primer()
        for byte in TYPICAL + typical:
            self.model.byte(known, byte)

    def decode(self, data, length):
        """A text of a length. None if the bytes hold none of that length."""
        if length > 65536 + 64 * len(data):
            return None
        substream, before = Substream(data), len(self.model.text)
        read = _Reader(substream)
        for _ in range(length):
            self.model.byte(read)
        return bytes(self.model.text[before:]) if substream.is_finished() else None
