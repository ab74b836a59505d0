"""The audit: a certificate that all engines run the same machine, judged by Pinocchio and by closed forms."""

from harness.audit.audit import audit, certify
from harness.audit.certificate import Certificate, Row

__all__ = ["Certificate", "Row", "audit", "certify"]
