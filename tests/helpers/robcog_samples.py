"""Event data as RobCoG writes it, of both of its generations."""

from __future__ import annotations

ED = """<?xml version="1.0"?><!DOCTYPE rdf:RDF[<!ENTITY log "http://knowrob.org/kb/{log}#">
<!ENTITY knowrob "http://knowrob.org/kb/{knowrob}#">]>
<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#" xmlns:owl="http://www.w3.org/2002/07/owl#"
 xmlns:knowrob="http://knowrob.org/kb/{knowrob}#">
<owl:NamedIndividual rdf:about="&log;E"><rdf:type rdf:resource="&knowrob;UnrealExperiment"/>
 <knowrob:startTime rdf:resource="&log;timepoint_0.0"/>
 <knowrob:endTime rdf:resource="&log;timepoint_9.0"/></owl:NamedIndividual>
{events}</rdf:RDF>"""
EVENT = """<owl:NamedIndividual rdf:about="&log;{id}"><rdf:type rdf:resource="&knowrob;{type}"/>
 <knowrob:startTime rdf:resource="&log;timepoint_{start}"/><knowrob:endTime rdf:resource="&log;timepoint_{end}"/>
 {roles}</owl:NamedIndividual>"""


Lines = tuple[tuple[str, str, object, object, dict[str, str]], ...]


def event_data(*lines: tuple[str, str, object, object, dict[str, str]], old: bool = False) -> str:
    text = [
        EVENT.format(id=i, type=t, start=s, end=e,
                     roles="".join(f'<knowrob:{k.strip("_")} rdf:resource="&log;{v}"/>' for k, v in roles.items()))
        for i, t, s, e, roles in lines
    ]  # fmt: skip
    names = (
        {"log": "unreal_log.owl", "knowrob": "knowrob_u.owl"}
        if old
        else {"log": "ameva_log.owl", "knowrob": "knowrob.owl"}
    )
    return ED.format(events="".join(text), **names)


TIMELINE = (
    ("g", "GraspingSomething", 3.5, 5, {"performedBy": "hand", "objectActedOn": "cup"}),
    ("t", "TouchingSituation", 1.25, 2.5, {"inContact": "hand", "inContact_": "cup"}),
    ("s", "SupportedBySituation", 0.5, 4, {"isSupported": "cup", "isSupporting": "table"}),
    ("r", "ReachingForSomething", 1, 2, {"performedBy": "hand", "objectActedOn": "cup"}),
    ("c", "ContainerManipulation", 6, 7, {"performedBy": "hand", "objectActedOn": "cup"}),
)
